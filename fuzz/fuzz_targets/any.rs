#![no_main]

libfuzzer_sys::fuzz_target!(
    init: superform_fuzz::let_panics_be_caught(),
    |bytes: &[u8]| superform_fuzz::any_format(bytes)
);
