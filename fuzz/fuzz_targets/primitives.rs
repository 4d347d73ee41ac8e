#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| superform_fuzz::primitives(bytes));
