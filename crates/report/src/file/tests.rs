use super::*;

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

/// A pipe, a device, and links to them stay what they are. Only root can make the device: a node of
/// its own, so that no error can destroy one that the machine needs.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_and_stays() {
    use std::os::unix::fs::FileTypeExt as _;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let make = |arguments: &[&str]| {
        let mut command = std::process::Command::new(arguments[0]);
        let output = command.args(&arguments[1..]).current_dir(folder.path()).output();
        output.is_ok_and(|output| output.status.success())
    };
    assert!(make(&["mkfifo", "pipe"]));
    let has_device = make(&["mknod", "device", "c", "1", "3"]);
    for original in ["pipe", "device"] {
        std::os::unix::fs::symlink(original, at(&format!("{original}-link"))).unwrap();
    }
    let before = names(folder.path());
    for name in ["pipe", "pipe-link", "device", "device-link"] {
        if name.starts_with("device") && !has_device {
            continue;
        }
        let refused = write_atomically(&at(name), b"new").unwrap_err().to_string();
        assert!(refused.contains(name) && refused.contains("a device, a pipe"), "{refused}");
        assert!(probe(&at(name)).unwrap_err().to_string().contains("a device, a pipe"));
        let kind = at(name).metadata().unwrap().file_type();
        assert!(kind.is_fifo() || kind.is_char_device(), "{name}");
        assert_eq!(at(name).is_symlink(), name.ends_with("link"), "{name}");
    }
    assert_eq!(names(folder.path()), before);
}

#[test]
fn leftovers_go_unless_their_writer_is_at_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.json");
    let kept = ["run.json", "other.drape-12345678.tmp", "run.json.12345678.tmp", "x.tmp"];
    let others = ["run.json.drape-1234567.tmp", "run.json.drape-1234-678.tmp"];
    for name in kept.iter().chain(&others).chain(&["run.json.drape-a1B2c3D4.tmp"]) {
        std::fs::write(folder.path().join(name), "half a rec").unwrap();
    }
    let working = temporary(&path).unwrap();
    probe(&path).unwrap();
    let mut expected: Vec<_> = kept.iter().chain(&others).map(|name| (*name).to_owned()).collect();
    expected.push(working.path().file_name().unwrap().to_str().unwrap().to_owned());
    expected.sort();
    assert_eq!(names(folder.path()), expected);
}

/// Eight writers of one file, each of which clears up after the others.
#[test]
fn writers_that_share_a_folder_do_not_meet() {
    let folder = tempfile::tempdir().unwrap();
    let path = &folder.path().join("run.json");
    std::thread::scope(|scope| {
        for writer in 0..8_u8 {
            scope.spawn(move || {
                for _ in 0..50 {
                    write_atomically(path, &[b'0' + writer; 4000]).unwrap();
                    probe(path).unwrap();
                    let found = std::fs::read(path).unwrap();
                    assert!(found.len() == 4000 && found.iter().all(|byte| *byte == found[0]));
                }
            });
        }
    });
    assert_eq!(names(folder.path()), ["run.json"]);
}
