//! Pictures of results, as a person or a script asks for them. They need a
//! Vulkan or GL driver (Mesa's lavapipe will do); without one they are skipped,
//! or fail if SUPERFORM_REQUIRE_GPU=1.

#[cfg(not(feature = "window"))]
use crate::process::{stderr, superform};

#[cfg(not(feature = "window"))]
#[test]
fn a_build_that_can_not_draw_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let output = superform(folder.path(), &["render", "out"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("feature `window`"), "{}", stderr(&output));
}

#[cfg(feature = "window")]
mod drawn {
    use std::fs;
    use std::path::Path;

    use image::{Rgba, RgbaImage};
    use superform::pictures::Painter;

    use crate::needs::drawn;
    use crate::process::{stderr, superform};

    /// Whether pictures can be drawn here.
    fn can_draw() -> bool {
        drawn(Painter::new()).is_some()
    }

    /// Two boxes of points, one above the other, and one point that is none.
    fn write_cloud(path: &Path) {
        let mut text = String::new();
        for i in 0..14 {
            for j in 0..14 {
                for (y, size) in [(0.0, 0.1), (0.25, 0.1), (0.8, 0.04), (1.4, 0.04)] {
                    let at = |k: i32| size * (f64::from(k) - 6.5);
                    text.push_str(&format!("{} {y} {}\n", at(i), 0.6 * at(j)));
                }
            }
        }
        text.push_str("nan 0 0\n");
        fs::write(path, text).unwrap();
    }

    /// Makes a result in the folder `name`, and leaves its input beside.
    fn result(folder: &Path, name: &str, seed: &str) {
        write_cloud(&folder.join("in.xyz"));
        let settings = ["--points", "400", "--iterations", "3", "--clusters", "6", "--seed", seed, "-q"];
        let output = superform(folder, &[&["run", "in.xyz", "-o", name][..], &settings].concat());
        assert!(output.status.success(), "{}", stderr(&output));
    }

    /// Renders, and gives what was said.
    fn render(folder: &Path, args: &[&str]) -> String {
        let output = superform(folder, &[&["render"][..], args].concat());
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        let said = stderr(&output);
        assert!(!said.contains("XDG_RUNTIME_DIR"), "{args:?}: {said}");
        String::from_utf8(output.stdout).unwrap() + &said
    }

    fn picture(path: &Path) -> RgbaImage {
        image::open(path).unwrap().to_rgba8()
    }

    /// Whether a pixel has the colour of data: backgrounds, grids and points
    /// without a primitive are nearly grey.
    fn is_colored(p: &Rgba<u8>) -> bool {
        p[3] > 128 && p.0[..3].iter().max().unwrap() - p.0[..3].iter().min().unwrap() > 60
    }

    fn colored(picture: &RgbaImage) -> usize {
        picture.pixels().filter(|p| is_colored(p)).count()
    }

    #[test]
    fn a_picture_has_the_size_asked_for_shows_the_result_and_is_the_same_again() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        result(folder, "out", "1");
        let said = render(folder, &["out", "-o", "one.png", "--size", "320x240"]);
        assert_eq!(said, "wrote one.png\n");
        let one = picture(&folder.join("one.png"));
        assert_eq!(one.dimensions(), (320, 240));
        let share = colored(&one) as f64 / (320.0 * 240.0);
        assert!(share > 0.05 && share < 0.8, "{share}");
        // All is in the picture, with a margin.
        let at_edge = |x, y| !(8..312).contains(&x) || !(6..234).contains(&y);
        let cut = one.enumerate_pixels().filter(|(x, y, p)| at_edge(*x, *y) && is_colored(p)).count();
        assert_eq!(cut, 0);

        // The file itself, in a folder that is made; nothing depends on chance.
        let said = render(folder, &["out/primitives.json", "-o", "pictures", "--size", "320x240", "-q"]);
        assert_eq!(said, "");
        let again = fs::read(folder.join("pictures/out.png")).unwrap();
        assert!(again == fs::read(folder.join("one.png")).unwrap(), "the bytes differ");
        // Without a place it is the present folder, and the usual size.
        render(folder, &["out"]);
        assert_eq!(picture(&folder.join("out.png")).dimensions(), (1200, 900));
    }

    #[test]
    fn views_are_named_and_differ() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        result(folder, "out", "1");
        let views = ["front", "right", "top", "back", "left", "bottom", "perspective"];
        let args = ["out", "-o", "v", "--size", "96x72", "--view", &views.join(",")];
        render(folder, &args);
        let taken = views.map(|view| picture(&folder.join(format!("v/out-{view}.png"))));
        for i in 0..taken.len() {
            for j in 0..i {
                assert!(taken[i] != taken[j], "{} and {} are the same", views[i], views[j]);
            }
        }
        // From the right it looks as it does where the eye is turned by 90
        // degrees, but for perspective.
        render(
            folder,
            &["out", "-o", "turned.png", "--azimuth", "90", "--elevation", "0", "--size", "96x72"],
        );
        let (turned, right) = (picture(&folder.join("turned.png")), &taken[1]);
        let both =
            turned.pixels().zip(right.pixels()).filter(|(a, b)| is_colored(a) && is_colored(b)).count();
        assert!(both * 10 > colored(right) * 7, "{both} of {}", colored(right));
        // One file for several views has their names added.
        render(folder, &["out", "-o", "two.png", "--view", "front,top", "--size", "96x72"]);
        assert!(folder.join("two-front.png").exists() && folder.join("two-top.png").exists());
    }

    #[test]
    fn what_is_asked_for_is_shown() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        result(folder, "out", "1");
        let take = |options: &[&str]| {
            let size = if options.contains(&"error") { "400x300" } else { "160x120" };
            render(folder, &[&["out", "-o", "p.png", "--size", size][..], options].concat());
            picture(&folder.join("p.png"))
        };
        let full = take(&[]);
        assert_eq!(colored(&take(&["--show", "grid"])), 0);
        assert_eq!(colored(&take(&["--hide", "points,primitives"])), 0);
        let solid = take(&["--show", "primitives", "--style", "solid"]);
        let wire = take(&["--show", "primitives", "--style", "wire"]);
        assert!(colored(&wire) < colored(&solid), "{} {}", colored(&wire), colored(&solid));
        let corner = |picture: &RgbaImage| picture.get_pixel(2, 2).0;
        assert!(corner(&full)[0] < 80 && corner(&take(&["--theme", "light"]))[0] > 200);
        let clear = take(&["--transparent"]);
        assert_eq!(corner(&clear)[3], 0);
        assert!(clear.pixels().filter(|p| p[3] > 200).count() > 500);
        assert!(take(&["--point-size", "12"]) != full && take(&["--up", "z"]) != full);
        // Numbers come with a legend, in the corner.
        let errors = take(&["--color-by", "error", "--hide", "grid"]);
        let legend = errors.enumerate_pixels().filter(|(x, y, _)| *x < 170 && *y > 232);
        let colors: Vec<_> = legend.map(|(.., p)| p).collect();
        assert!(colors.iter().any(|p| p[0] > 200 && p[2] < 80), "the yellow end of the bar");
        assert!(colors.iter().filter(|p| p[0] > 180 && p[2] > 180).count() > 20, "its text");
        take(&["--color-by", "surface"]);
    }

    /// Points have the labels that the segmented cloud beside the primitives
    /// gives them; where there is none, they are told apart anew.
    #[test]
    fn labels_are_those_of_the_segmented_cloud() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        result(folder, "out", "1");
        let args = ["out", "-o", "p.png", "--size", "160x120", "--show", "points", "--point-size", "8"];
        let points = || {
            render(folder, &args);
            colored(&picture(&folder.join("p.png")))
        };
        let labelled = points();
        assert!(labelled > 500, "{labelled}");
        let segmented = folder.join("out/segmented.ply");
        let superform::io::ShapeGeometry::Cloud(cloud) = superform::io::read(&segmented).unwrap().geometry
        else {
            panic!()
        };
        fs::remove_file(&segmented).unwrap();
        let anew = points();
        assert!(anew.abs_diff(labelled) * 5 < labelled, "{anew} instead of {labelled}");
        let count = cloud.points.len();
        let header = format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty double x\nproperty double y\n\
             property double z\nproperty int label\nend_header\n"
        );
        let rows: String = cloud.points.iter().map(|p| format!("{} {} {} -1\n", p.x, p.y, p.z)).collect();
        fs::write(&segmented, header + &rows).unwrap();
        assert_eq!(points(), 0, "none belongs to a primitive");
    }

    #[test]
    fn a_sheet_has_a_cell_for_each_result_also_for_a_broken_one() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        for (name, seed) in [("batch/a", "1"), ("batch/c", "2")] {
            result(folder, name, seed);
        }
        fs::create_dir_all(folder.join("batch/b")).unwrap();
        fs::write(folder.join("batch/b/primitives.json"), "{\"format\": \"superform-primitives\"").unwrap();
        let args = ["render", "batch", "--sheet", "s.png", "--columns", "2", "--size", "160x120"];
        let output = superform(folder, &args);
        assert_eq!(output.status.code(), Some(11), "one of three failed");
        let said = stderr(&output);
        assert!(said.contains("b: ") && said.contains("primitives.json"), "{said}");
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "wrote s.png\n");
        let sheet = picture(&folder.join("s.png"));
        assert_eq!(sheet.width(), 2 * 36 + 2 * 160 + 28);
        let cell = |column: u32, row: u32| {
            let (x, y) = (36 + column * (160 + 28), 36 + row * (120 + 10 + 46 + 28));
            let part = |y, height| image::imageops::crop_imm(&sheet, x, y, 160, height).to_image();
            let text = part(y + 130, 46);
            (colored(&part(y, 120)), text.pixels().filter(|p| p[1] > 100).count())
        };
        let cells = [cell(0, 0), cell(1, 0), cell(0, 1)];
        assert!(cells[0].0 > 500 && cells[1].0 == 0 && cells[2].0 > 500, "{cells:?}");
        assert!(cells.iter().all(|(_, text)| *text > 20), "each has a caption: {cells:?}");
        // No pictures of their own, unless they are asked for.
        assert!(!folder.join("a.png").exists());
        let args = ["batch/a", "batch/c", "--sheet", "s.png", "-o", "each", "--size", "64x48"];
        let said = render(folder, &args);
        assert_eq!(said.lines().count(), 3, "{said}");
        assert_eq!(picture(&folder.join("each/c.png")).dimensions(), (64, 48));
    }

    #[test]
    fn a_turntable_turns() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        result(folder, "out", "1");
        let args = ["out", "-o", "t.gif", "--turntable", "4", "--seconds", "2", "--size", "96x72"];
        assert_eq!(render(folder, &args), "wrote t.gif\n");
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(fs::File::open(folder.join("t.gif")).unwrap()).unwrap();
        assert_eq!((reader.width(), reader.height()), (96, 72));
        let mut frames = Vec::new();
        while let Some(frame) = reader.read_next_frame().unwrap() {
            assert_eq!(frame.delay, 50);
            frames.push(frame.buffer.to_vec());
        }
        assert_eq!(frames.len(), 4);
        assert!(frames.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn shapes_and_sessions_are_drawn_too() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let session = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/session-1.superform");
        fs::copy(session, folder.join("left.superform")).unwrap();
        write_cloud(&folder.join("cloud.xyz"));
        fs::write(folder.join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n")
            .unwrap();
        // A folder without results stands for what is in it.
        render(folder, &[".", "-o", "p", "--size", "160x120", "--hide", "grid"]);
        for name in ["left", "cloud", "mesh"] {
            let taken = picture(&folder.join(format!("p/{name}.png")));
            let empty = taken.get_pixel(0, 0).0;
            let drawn = taken.pixels().filter(|p| p.0[0].abs_diff(empty[0]) > 40).count();
            assert!(drawn > 50, "{name}: {drawn}");
        }
        // What can't be told is said.
        let said = render(folder, &["cloud.xyz", "-o", "c.png", "--size", "64x48", "--color-by", "error"]);
        assert!(said.contains("cloud: ") && said.contains("no error"), "{said}");
    }

    #[cfg(unix)]
    #[test]
    fn a_picture_goes_to_standard_output_and_never_over_what_is_read() {
        if !can_draw() {
            return;
        }
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        write_cloud(&folder.join("c.xyz"));
        let size = ["--size", "64x48"];
        let output = superform(folder, &[&["render", "c.xyz", "-o", "-"][..], &size].concat());
        let said = stderr(&output);
        assert!(output.status.success() && said.lines().count() == 1, "{said}");
        assert!(said.contains("non-finite"), "of the shape, and of nothing else: {said}");
        render(folder, &[&["c.xyz", "-o", "c.png"][..], &size].concat());
        assert!(output.stdout == fs::read(folder.join("c.png")).unwrap() && !folder.join("-").exists());
        let before = fs::read(folder.join("c.xyz")).unwrap();
        std::os::unix::fs::symlink("c.xyz", folder.join("link.png")).unwrap();
        for args in [&["-o", "link.png"][..], &["--sheet", "link.png"]] {
            let output = superform(folder, &[&["render", "c.xyz"][..], args, &size].concat());
            assert_eq!(output.status.code(), Some(1));
            assert!(stderr(&output).contains("overwrite the input"), "{}", stderr(&output));
        }
        assert!(fs::read(folder.join("c.xyz")).unwrap() == before);
    }

    #[test]
    fn what_can_not_be_drawn_is_told_in_one_sentence() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path();
        let refused = |args: &[&str], code: i32, word: &str| {
            let output = superform(folder, &[&["render"][..], args].concat());
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
            assert!(said.contains(word) && said.lines().count() <= 2, "{args:?}: {said}");
        };
        refused(&["."], 1, "neither a result nor a shape");
        refused(&["*.ply"], 1, "matches nothing");
        refused(&["a.obj", "-o", "a.gif"], 2, "--turntable");
        refused(&["a.obj", "-o", "a.jpg"], 2, "ends with .jpg");
        refused(&["a.obj", "--sheet", "a.jpg"], 2, "the ending .png");
        assert!(!folder.join("a.jpg").exists());
        refused(&["a.obj", "b.obj", "-o", "a.png"], 1, "2 results");
        if can_draw() {
            refused(&["missing.obj"], 1, "missing.obj");
            fs::write(folder.join("empty.xyz"), "nan nan nan\n").unwrap();
            refused(&["empty.xyz"], 1, "empty.xyz");
            fs::write(folder.join("file"), "").unwrap();
            write_cloud(&folder.join("c.xyz"));
            refused(&["c.xyz", "-o", "file"], 1, "file");
            assert!(!folder.join("missing.png").exists());
        }
        // A driver that isn't there is told, too.
        if cfg!(target_os = "linux") {
            fs::write(folder.join("c.xyz"), "0 0 0\n1 0 0\n0 1 0\n").unwrap();
            let output = std::process::Command::new(env!("CARGO_BIN_EXE_superform"))
                .args(["render", "c.xyz"])
                .current_dir(folder)
                .env("WGPU_BACKEND", "dx12")
                .env("XDG_RUNTIME_DIR", folder)
                .output()
                .unwrap();
            let said = stderr(&output);
            assert_eq!(output.status.code(), Some(1), "{said}");
            assert!(said.contains("no graphics driver") && said.lines().count() == 1, "{said}");
        }
    }
}
