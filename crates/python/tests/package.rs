//! The Python package, as `cargo test` has built it. `DRAPE_PYTHON` names a Python with NumPy. Some
//! tests also need mypy, matplotlib or, where pip reaches no index, maturin. A test that finds no
//! such Python says that it was skipped.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const HERE: &str = env!("CARGO_MANIFEST_DIR");

/// A Python with these packages. Without one, the test is skipped with a message, or fails where
/// `DRAPE_PYTHON_PACKAGES=required`.
fn python(packages: &str) -> Option<String> {
    let python = std::env::var("DRAPE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = format!("import {packages}");
    let found = Command::new(&python).args(["-c", &import]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    let said = format!("SKIPPED: `{python} -c '{import}'` fails; name another in DRAPE_PYTHON");
    let is_required = std::env::var("DRAPE_PYTHON_PACKAGES").is_ok_and(|word| word == "required");
    assert!(!is_required, "{said}");
    // Past the test's capture.
    writeln!(std::io::stderr().lock(), "{said}").unwrap();
    None
}

/// A file that the same build made, by its name beside the tests or one folder up.
fn built(names: &[&str]) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let folders = test.ancestors().skip(1).take(2);
    let mut files = folders.flat_map(|folder| names.iter().map(|name| folder.join(name)));
    files.find(|file| file.is_file()).unwrap_or_else(|| {
        panic!("{names:?} is not built: run `cargo test --workspace`");
    })
}

/// The package as `pip install` lays it out.
fn lay_out(folder: &Path) {
    let package = folder.join("drape");
    std::fs::create_dir(&package).unwrap();
    for name in ["__init__.py", "_drape.pyi", "py.typed"] {
        std::fs::copy(Path::new(HERE).join("python/drape").join(name), package.join(name)).unwrap();
    }
    let module = built(&["lib_drape.so", "lib_drape.dylib"]);
    std::fs::copy(module, package.join("_drape.abi3.so")).unwrap();
}

fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{command:?}:\n{out}{err}");
    out.into_owned()
}

/// All checks of `check.py`, beside the command of the same build.
#[test]
fn python_sees_what_the_command_prints() {
    let Some(python) = python("numpy") else { return };
    let folder = tempfile::tempdir().unwrap();
    lay_out(folder.path());
    let mut command = Command::new(python);
    let command = command.arg(Path::new(HERE).join("tests/check.py")).arg(built(&["drape"]));
    let said = run(command.env("PYTHONPATH", folder.path()));
    assert_eq!(said.lines().count(), 8, "{said}");
}

/// A `cargo` that answers maturin with the library of this build, so that nothing is built twice.
const CARGO: &str = r#"#!/bin/sh
case " $* " in
*" rustc "*)
    printf '{"reason":"compiler-artifact","package_id":"path+file://%s#' "$HERE"
    printf 'drape-python@%s","manifest_path":"%s/Cargo.toml",' "$VERSION" "$HERE"
    printf '"target":{"kind":["cdylib"],"crate_types":["cdylib"],"name":"_drape",'
    printf '"src_path":"%s/src/lib.rs","edition":"2024","doctest":false,"test":false},' "$HERE"
    printf '"profile":{"opt_level":"2","debuginfo":1,"debug_assertions":true,'
    printf '"overflow_checks":true,"test":false},"features":[],'
    printf '"filenames":["%s"],"executable":null,"fresh":true}\n' "$LIBRARY"
    echo '{"reason":"build-finished","success":true}' ;;
*) exec "$CARGO_ITSELF" "$@" ;;
esac
"#;

/// Runs `pip install` of the checkout in a fresh virtual environment, as the README says, and all
/// checks of `check.py` there. pip fetches NumPy and maturin from its index. maturin packs the
/// build of `cargo test`, because a `cargo` of this test comes first in its path. Where pip reaches
/// no index, NumPy and maturin are those of the Python outside, and the test says so.
#[test]
fn pip_installs_it_from_the_checkout_into_a_fresh_environment() {
    let Some(outside) = python("ensurepip, venv") else { return };
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    run(Command::new(&outside).args(["-m", "venv"]).arg(place("env")));
    // The inner Python sees only the packages of the environment.
    let inside = |words: &[&str]| {
        let mut command = Command::new(place("env/bin/python"));
        command.args(words).env_remove("PYTHONPATH").current_dir(folder.path());
        command
    };
    let fetch = ["-m", "pip", "download", "-q", "--no-deps", "--retries", "1", "--timeout", "30"];
    let mut fetch = inside(&fetch);
    fetch.args(["--dest", "wheels", "numpy>=1.24", "maturin>=1.9,<2"]);
    let is_fetched = fetch.output().unwrap().status.success();

    let mut install = inside(&["-m", "pip", "install", "-q"]);
    let mut path = vec![place("bin")];
    if !is_fetched {
        let said =
            "SKIPPED: pip reaches no index, so nobody checked that it fetches NumPy and maturin";
        // Past the test's capture.
        writeln!(std::io::stderr().lock(), "{said}").unwrap();
        let Some(outside) = python("numpy, maturin") else { return };
        let script = "import maturin, numpy, os, sysconfig\n\
                      print(sysconfig.get_path('scripts'))\n\
                      for module in (maturin, numpy):\n    \
                      print(os.path.dirname(os.path.dirname(module.__file__)))";
        let folders = run(Command::new(outside).args(["-c", script]));
        let (scripts, packages) = folders.split_once('\n').unwrap();
        path.push(scripts.into());
        let site =
            run(&mut inside(&["-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]));
        std::fs::write(Path::new(site.trim()).join("outside.pth"), packages).unwrap();
        install.args(["--no-build-isolation", "--no-deps"]);
    }
    let cargo = place("bin/cargo");
    std::fs::create_dir(place("bin")).unwrap();
    std::fs::write(&cargo, CARGO).unwrap();
    std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).unwrap();
    let before = std::env::var_os("PATH").unwrap_or_default();
    path.extend(std::env::split_paths(&before));
    install.arg(HERE).env("PATH", std::env::join_paths(path).unwrap());
    install.env("CARGO", &cargo).env("CARGO_ITSELF", env!("CARGO")).env("HERE", HERE);
    // maturin moves the library that it gets, and other tests need it, so give it a copy.
    let library = place("lib_drape.so");
    std::fs::copy(built(&["lib_drape.so", "lib_drape.dylib"]), &library).unwrap();
    install.env("LIBRARY", &library);
    run(install.env("VERSION", env!("CARGO_PKG_VERSION")));

    let script = "import drape, importlib.metadata as m, numpy, pathlib, sys\n\
                  own = lambda module: pathlib.Path(module.__file__).is_relative_to(sys.prefix)\n\
                  print(drape.__version__, m.version('drape'), m.requires('drape'))\n\
                  print(own(drape), own(numpy))\n\
                  print(pathlib.Path(drape.__file__).parent)";
    let said = run(&mut inside(&["-c", script]));
    let [versions, owned, package] = said.lines().collect::<Vec<_>>()[..] else {
        panic!("{said}");
    };
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(versions, format!("{version} {version} ['numpy>=1.24']"));
    assert_eq!(owned, if is_fetched { "True True" } else { "True False" });
    for name in ["__init__.py", "_drape.abi3.so", "_drape.pyi", "py.typed"] {
        assert!(Path::new(package).join(name).is_file(), "{name}");
    }
    let checks =
        run(inside(&["-B"]).arg(Path::new(HERE).join("tests/check.py")).arg(built(&["drape"])));
    assert_eq!(checks.lines().count(), 8, "{checks}");
}

/// The stubs match the module, and the types of the example are correct.
#[test]
fn the_types_are_those_of_the_module() {
    let Some(python) = python("numpy, mypy") else { return };
    let folder = tempfile::tempdir().unwrap();
    lay_out(folder.path());
    let example = Path::new(HERE).join("examples/redraw_figure.py");
    let mypy = |words: &[&str]| {
        let mut command = Command::new(&python);
        command.arg("-m").args(words).env("MYPYPATH", folder.path());
        command.env("PYTHONPATH", folder.path()).current_dir(folder.path());
        command
    };
    let strict = ["mypy", "--strict", "--ignore-missing-imports"];
    run(mypy(&strict).arg(&example));
    run(&mut mypy(&["mypy.stubtest", "drape"]));
    // The checker finds a wrong use.
    let wrong = folder.path().join("wrong.py");
    std::fs::write(&wrong, "import drape\ndrape.run('scene', 3)\n").unwrap();
    let output = mypy(&strict).arg(&wrong).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("incompatible type \"str\"; expected \"Scene\""), "{said}");
}

/// The points of the figure are those of the committed record.
#[test]
fn the_example_redraws_the_recorded_figure() {
    let Some(python) = python("numpy, matplotlib") else { return };
    let folder = tempfile::tempdir().unwrap();
    lay_out(folder.path());
    let figure = folder.path().join("figure.png");
    let mut command = Command::new(python);
    let command = command.arg(Path::new(HERE).join("examples/redraw_figure.py")).arg(&figure);
    let record = Path::new(HERE).join("../../results/cg-vs-stiffness.json");
    let said = run(command.arg(record).env("PYTHONPATH", folder.path()));
    assert_eq!(said.matches("as recorded").count(), 3, "{said}");
    assert!(std::fs::metadata(figure).unwrap().len() > 10_000);
}
