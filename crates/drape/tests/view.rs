//! What can be seen: frames, animations, pictures, as a user meets them.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;
use std::process::{Command, Output};

fn drape(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drape")).current_dir(folder).args(arguments).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn message(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

const RUN: [&str; 4] = ["run", "square-table-1e4", "--method", "imex-euler"];

/// Coordinates of an OBJ file, as bits.
fn vertices(text: &str) -> Vec<[u64; 3]> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    let read = |line: &str| -> Vec<u64> {
        line.split(' ').map(|number| number.parse::<f64>().unwrap().to_bits()).collect()
    };
    lines.map(|line| read(line).try_into().unwrap()).collect()
}

#[test]
fn frames_hold_the_start_the_end_and_every_particle_in_its_order() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--duration", "0.2", "--frames", "a/frames", "--out", "run.json"];
    let output = drape(folder.path(), &[&RUN[..], &more].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    let frames = folder.path().join("a/frames");
    let mut names: Vec<_> = std::fs::read_dir(&frames)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let mut expected: Vec<_> = (0..6).map(|n| format!("frame-{n:04}.obj")).collect();
    expected.push("obstacles.obj".to_owned());
    assert_eq!(names, expected);
    let read = |name: &str| std::fs::read_to_string(frames.join(name)).unwrap();
    let run: drape_harness::record::Run =
        drape_report::file::read_json(&folder.path().join("run.json")).unwrap();
    let input = drape_model::load("square-table-1e4").unwrap();
    let (system, state) = input.spec().build().unwrap();
    let last: Vec<drape_model::Vec3> =
        run.final_state.position_m.iter().map(|&x| x.into()).collect();
    for (name, x) in [(&names[0], &state.x), (&names[5], &last)] {
        let shown = system.display_positions(x, 0.0);
        let bits: Vec<_> = shown.iter().map(|x| [x.x, x.y, x.z].map(f64::to_bits)).collect();
        assert_eq!(vertices(&read(name)), bits, "{name}");
    }
    assert_eq!(read(&names[5]).matches("\nf ").count(), 2 * 19 * 19);
    assert_eq!(vertices(&read("obstacles.obj")).len(), 8);
    // A second run does not write over the first.
    let again = drape(folder.path(), &[&RUN[..], &more].concat());
    assert_eq!(code(&again), 2);
    assert!(message(&again).contains("--frames") && message(&again).contains("it holds files"));
}

#[test]
fn an_obstacle_that_moves_has_a_file_a_frame_and_is_seen_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let system = r#"{ "format": "drape-system/1",
        "particles": { "mass_kg": [1, 1, 1], "position_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]] },
        "triangles": [[0, 1, 2]], "obstacles": [{ "box": { "center_m": [0, 0, -1],
            "size_m": [2, 2, 2], "path": [{ "time_s": 0.1, "offset_m": [0, 0, 0.5] }] } }] }"#;
    std::fs::write(folder.path().join("s.json"), system).unwrap();
    let times = ["s.json", "--method", "imex-euler", "--dt", "0.01", "--duration", "0.2"];
    let run = ["--frames", "f", "--animation", "m.glb", "--fps", "50"];
    let output = drape(folder.path(), &[&["run"][..], &times, &run].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    let read = |name: &str| {
        vertices(&std::fs::read_to_string(folder.path().join("f").join(name)).unwrap())
    };
    let top = |name: &str| read(name).iter().map(|x| f64::from_bits(x[2])).fold(-9.0, f64::max);
    for (frame, height) in [(0, 0.0), (2, 0.2), (5, 0.5), (10, 0.5)] {
        let found = top(&format!("obstacles-{frame:04}.obj"));
        assert!((found - height).abs() < 1e-9, "frame {frame}: {found}");
        let cloth = top(&format!("frame-{frame:04}.obj"));
        assert!(cloth >= height - 1e-12, "frame {frame}: the cloth is shown at {cloth}");
    }
    assert!(!folder.path().join("f/obstacles.obj").exists());
    let file = gltf::Gltf::open(folder.path().join("m.glb")).unwrap();
    assert_eq!(file.animations().next().unwrap().channels().count(), 2);
    let picture = ["--size", "200x150", "--camera", "front", "--out", "p.png"];
    let both = ["--time", "0", "--time", "0.2"];
    let output = drape(folder.path(), &[&["picture"][..], &times, &picture, &both].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_ne!(bytes("p-1.png"), bytes("p-2.png"));
}

#[test]
fn steps_longer_than_frames_are_frames_each() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--duration", "0.05", "--fps", "1000", "--frames", "f", "--animation", "m.glb"];
    assert_eq!(code(&drape(folder.path(), &[&RUN[..], &more].concat())), 0);
    assert!(folder.path().join("f/frame-0005.obj").is_file());
    assert!(!folder.path().join("f/frame-0006.obj").exists());
    let bytes = std::fs::read(folder.path().join("m.glb")).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.clone().unwrap();
    let animation = file.animations().next().unwrap();
    let times: Vec<f32> = animation
        .channels()
        .next()
        .unwrap()
        .reader(|_| Some(&blob))
        .read_inputs()
        .unwrap()
        .collect();
    assert_eq!(times, [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]);
    assert_eq!(file.meshes().count(), 2, "cloth and table");
}

/// A sheet in disorder, large enough to be renumbered, is written in the order of its file.
#[test]
fn a_system_in_disorder_is_shown_in_its_own_order() {
    let folder = tempfile::tempdir().unwrap();
    let input = drape_model::load("square-table-2704-1e6").unwrap();
    let mut spec = input.spec().clone();
    let n = spec.particles.mass_kg.len();
    let new: Vec<usize> = (0..n).map(|i| i * 787 % n).collect(); // no common factor
    let old = spec.particles.position_m.clone();
    for (i, &k) in new.iter().enumerate() {
        spec.particles.position_m[k] = old[i];
    }
    let place = |i: &mut u32| *i = new[*i as usize] as u32;
    for spring in &mut spec.springs {
        place(&mut spring.i);
        place(&mut spring.j);
    }
    spec.triangles.iter_mut().flatten().for_each(place);
    std::fs::write(folder.path().join("s.json"), serde_json::to_string(&spec).unwrap()).unwrap();
    let run = ["run", "s.json", "--method", "imex-euler", "--dt", "0.01", "--duration", "0.01"];
    let output = drape(folder.path(), &[&run[..], &["--frames", "f", "--fps", "100"]].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    for frame in ["f/frame-0000.obj", "f/frame-0001.obj"] {
        let text = std::fs::read_to_string(folder.path().join(frame)).unwrap();
        for (bits, x) in vertices(&text).iter().zip(&spec.particles.position_m) {
            let moved = (0..3).map(|n| (f64::from_bits(bits[n]) - x[n]).abs()).fold(0.0, f64::max);
            assert!(moved < 1e-2, "{frame}: particle moved by {moved} m in one step");
        }
    }
}

#[test]
fn pictures_are_drawn_one_a_time_and_a_diverged_run_is_marked() {
    let folder = tempfile::tempdir().unwrap();
    let picture = ["picture", "hanging-textile-1e6", "--dt", "0.01", "--size", "200x150"];
    let more = ["--method", "imex-euler", "--time", "0.1", "--time", "0", "--out", "p.png"];
    let output = drape(folder.path(), &[&picture[..], &more].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let (late, start) = (bytes("p-1.png"), bytes("p-2.png"));
    assert_ne!(late, start);
    let reader = png::Decoder::new(std::io::Cursor::new(late)).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (200, 150));

    let more = ["--method", "explicit-euler", "--out", "d.png", "--camera", "30,10"];
    let output = drape(folder.path(), &[&picture[..], &more].concat());
    assert_eq!(code(&output), 3, "{}", message(&output));
    assert!(message(&output).contains("diverged at step"));
    assert!(!bytes("d.png").is_empty());
}

#[test]
fn several_methods_stand_side_by_side_before_one_camera() {
    let folder = tempfile::tempdir().unwrap();
    let picture = ["picture", "hanging-textile-1e4", "--dt", "0.01", "--duration", "0.2"];
    let size = ["--size", "200x150", "--out", "p.png"];
    let four = ["imex-euler", "imex-euler:solver=cholesky", "baraff-witkin", "imex-euler"];
    let methods: Vec<&str> = four.iter().flat_map(|method| ["--method", method]).collect();
    let output = drape(folder.path(), &[&picture[..], &size, &methods].concat());
    assert_eq!(code(&output), 0, "{}", message(&output));
    let file = std::fs::File::open(folder.path().join("p.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let (width, height) = (3 * 200 + 2 * 4, 2 * 150 + 4);
    assert_eq!((reader.info().width, reader.info().height), (width, height));
    reader.next_frame(&mut bytes).unwrap();
    let panel = |column: usize, row: usize| -> Vec<u8> {
        let start = |y: usize| 3 * ((row * 154 + y) * width as usize + column * 204);
        (0..150).flat_map(|y| bytes[start(y)..start(y) + 600].to_vec()).collect()
    };
    assert_eq!(panel(0, 0), panel(0, 1), "the same method, the same picture");
    assert_ne!(panel(0, 0), panel(2, 0), "another method, another motion");
    let bare = drape(folder.path(), &[&picture[..], &size, &["--no-ground"]].concat());
    assert_eq!(code(&bare), 0, "{}", message(&bare));
}

/// Two squares apart: two groups and two boundaries, each with a colour of its own. A mesh with a
/// hole has two boundaries in one group.
#[test]
fn an_inspection_shows_groups_and_boundaries_in_colours() {
    let folder = tempfile::tempdir().unwrap();
    let square = |x: f64, first: u32| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|n| first + n);
        let right = x + 1.0;
        format!("v {x} 0 0\nv {right} 0 0\nv {right} 1 0\nv {x} 1 0\nf {a} {b} {c} {d}\n")
    };
    let two = square(0.0, 1) + &square(2.0, 5);
    for (name, mesh) in [("one.obj", square(0.0, 1)), ("two.obj", two)] {
        std::fs::write(folder.path().join(name), mesh).unwrap();
    }
    // How many pixels are exactly in the colour of a mark: dots are not shaded.
    let [red, blue] = [0, 1].map(|n| drape_render::colours(n)[1].0);
    let marks = |scene: &str| {
        let output = drape(folder.path(), &["inspect", scene, "--picture", "p.png"]);
        assert_eq!(code(&output), 0, "{}", message(&output));
        assert!(!output.stdout.is_empty(), "the text is printed too");
        let file = std::fs::File::open(folder.path().join("p.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let near =
            |pixel: &[u8], tint: [u8; 3]| pixel.iter().zip(tint).all(|(a, b)| a.abs_diff(b) < 3);
        [red, blue].map(|tint| bytes.chunks(3).filter(|pixel| near(pixel, tint)).count())
    };
    let [one, two] = ["one.obj", "two.obj"].map(marks);
    assert!(one[0] > 40 && one[1] == 0, "{one:?}");
    assert!(two[0] > 40 && two[1] > 40, "{two:?}");
    let skirt = marks("skirt");
    assert!(skirt[0] > 200 && skirt[1] > 200, "a tube has two rims: {skirt:?}");
    let refused = drape(folder.path(), &["inspect", "skirt", "--picture", "p.jpg"]);
    assert_eq!(code(&refused), 2);
    assert!(message(&refused).contains("--picture"), "{}", message(&refused));
}

#[test]
fn what_cannot_be_shown_is_refused_before_anything_is_computed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), "mine").unwrap();
    let picture = &["picture", "square-table-1e4"][..];
    let cases: &[(&[&str], &[&str], &str)] = &[
        (&RUN, &["--frames", "f", "--fps", "0"], "--fps"),
        (&RUN, &["--frames", "f", "--fps", "-25"], "--fps"),
        (&RUN, &["--frames", "f", "--fps", "nan"], "--fps"),
        (&RUN, &["--frames", "f", "--fps", "1e7"], "--fps"),
        (&RUN, &["--fps", "25"], "--animation"),
        (&RUN, &["--frames", "file"], "--frames"),
        (&RUN, &["--frames", "file/below"], "--frames"),
        (&RUN, &["--frames", "."], "it holds files"),
        (&RUN, &["--animation", "file/m.glb"], "--animation"),
        (&RUN, &["--animation", "."], "--animation"),
        (&RUN, &["--animation", "m.glb", "--fps", "1e6", "--dt", "1e-4"], "1000 frames"),
        (picture, &["--time", "1.5"], "--time"),
        (picture, &["--time", "-1"], "--time"),
        (picture, &["--time", "nan"], "--time"),
        (picture, &["--size", "0x10"], "--size"),
        (picture, &["--size", "100"], "--size"),
        (picture, &["--size", "9999x9999"], "--size"),
        (picture, &["--camera", "behind"], "--camera"),
        (picture, &["--camera", "10,100"], "--camera"),
        (picture, &["--out", "file/p.png"], "--out"),
        (picture, &["--out", "."], "--out"),
        (picture, &["--out", "t.jpg"], "ends in .png"),
        (picture, &["--out", "t", "--time", "0", "--time", "1"], "ends in .png"),
        (picture, &["--method", "magic"], "imex-euler"),
        (picture, &["--dt", "0"], "--dt"),
        (picture, &["--method", "bdf2", "--method", "bdf2", "--set", "order=2"], "METHOD:KEY"),
    ];
    for (command, more, named) in cases {
        let output = drape(folder.path(), &[command, *more].concat());
        let text = message(&output);
        assert_eq!(code(&output), 2, "{more:?}: {text}");
        assert!(text.contains(named) && text.contains("expected"), "{more:?}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    }
    let left: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left, ["file"], "nothing is left behind");
    assert_eq!(std::fs::read_to_string(folder.path().join("file")).unwrap(), "mine");
}
