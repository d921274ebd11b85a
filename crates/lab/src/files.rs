//! Scenes, frozen systems and meshes that a person gave to a page.
//!
//! **No file of the server is read.** A scene may name a mesh. The lab takes the mesh of that name
//! from the files that the same page was given. It refuses a scene that names any other file.

use crate::limits;
use crate::setup::{Source, refuse};
use drape_model::fabric::Material;
use drape_model::{
    Cloth, DampingLaw, Effects, GravitySpec, MeshCloth, Pin, Scene, SceneError, SceneFile,
    SpringLaw, TimeSpan, Vec3, Violation,
};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Prefix of a file's name where the name of a scene is expected.
pub const PREFIX: &str = "file:";

/// Assumptions about a mesh that comes without a scene. Coordinates are metres.
const DENSITY_KG_M2: f64 = 0.2;
const STIFFNESS_PER_S2: f64 = 1e4;
const DAMPING_PER_S: f64 = 4.0;
const GRAVITY_M_S2: f64 = 9.81;
const TIME: TimeSpan = TimeSpan { step_s: 0.01, duration_s: 2.0 };
/// The keys of a mesh's scene whose values are such assumptions.
const ASSUMED: [&str; 5] =
    ["cloth.mesh.areal_density_kg_m2", "effects.tension", "effects.gravity", "pins", "time"];
/// Particles below the highest one by at most this share of the height count as equally high.
const LEVEL: f64 = 1e-6;

/// A file that can be shown.
#[derive(Clone, Debug)]
pub struct Dropped {
    /// The scene or the frozen system in the file. For a mesh, the scene that was made around it.
    pub source: Source,
    /// Name of the mesh that the scene reads, if any.
    pub mesh: Option<String>,
    /// Whether the file is the scene itself, and not a mesh.
    pub is_scene: bool,
    /// The repairs of a mesh, and the assumptions about it, in sentences.
    pub notes: Vec<String>,
}

/// The files that a page was given.
#[derive(Clone, Debug, Default)]
pub struct Files {
    meshes: BTreeMap<String, Arc<[u8]>>,
    shown: BTreeMap<String, Arc<Dropped>>,
    bytes: BTreeMap<String, usize>,
}

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The name, the kind or the size of the file was refused.
    #[error(transparent)]
    Violation(#[from] Violation),
    /// Its content was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// A name as a message quotes it.
fn quoted(name: &str) -> String {
    let short: String = name.chars().take(60).collect();
    format!("{short:?}")
}

impl Files {
    /// The scene of a file, by the file's name.
    pub fn get(&self, name: &str) -> Option<&Arc<Dropped>> {
        self.shown.get(name)
    }

    /// Takes a file. It replaces a file of the same name.
    ///
    /// # Errors
    /// [`FileError`] for the first fault of the name, the size or the content.
    pub fn add(&mut self, name: &str, bytes: &[u8]) -> Result<&Arc<Dropped>, FileError> {
        let is_plain = |c: char| !c.is_control() && !"/\\:".contains(c);
        let is_name = !name.trim().is_empty()
            && name.len() <= limits::NAME_BYTES
            && name.chars().all(is_plain)
            && !name.starts_with(['.', '-']);
        if !is_name {
            let expected = format!(
                "the name of a file, at most {} bytes long, without a folder",
                limits::NAME_BYTES
            );
            return Err(refuse("name of the file", quoted(name), expected).into());
        }
        let end = name.rsplit_once('.').map_or("", |(_, end)| end).to_ascii_lowercase();
        let most = match end.as_str() {
            "obj" => limits::MESH_BYTES,
            "json" => limits::FILE_BYTES,
            _ => {
                let expected = "a scene or a frozen system (.json), or a mesh (.obj); a scene can \
                                list particles in `cloth.particles`";
                return Err(refuse("name of the file", quoted(name), expected).into());
            }
        };
        if bytes.len() > most {
            let found = format!("{} bytes long", bytes.len());
            return Err(refuse(name, found, format!("at most {most} bytes")).into());
        }
        let others: usize =
            self.bytes.iter().filter(|(known, _)| *known != name).map(|(_, bytes)| bytes).sum();
        let count = self.bytes.len() + usize::from(!self.bytes.contains_key(name));
        if count > limits::FILES || others + bytes.len() > limits::FILES_BYTES {
            let found = format!("file {count}, with {} bytes in all", others + bytes.len());
            let (files, most) = (limits::FILES, limits::FILES_BYTES);
            let expected = format!(
                "at most {files} files and {most} bytes on a page: open the lab again to begin \
                 anew"
            );
            return Err(refuse(name, found, expected).into());
        }
        let dropped = if end == "obj" {
            let dropped = of_mesh(name, bytes)?;
            self.meshes.insert(name.to_owned(), bytes.into());
            dropped
        } else {
            self.of_json(name, bytes)?
        };
        check_size(name, &dropped.source)?;
        self.bytes.insert(name.to_owned(), bytes.len());
        self.shown.insert(name.to_owned(), Arc::new(dropped));
        Ok(&self.shown[name])
    }

    fn of_json(&self, name: &str, bytes: &[u8]) -> Result<Dropped, FileError> {
        let text = text(name, bytes)?;
        let plain = |file| {
            let (source, is_scene) = (of_file(file), true);
            Dropped { source, mesh: None, is_scene, notes: Vec::new() }
        };
        // A text that is no scene is a frozen system, or it is faulty. Neither names another file.
        let Ok(scene) = serde_json::from_str::<Scene>(text) else {
            return Ok(plain(drape_model::parse(name, text)?));
        };
        let invalid = |violation| SceneError::Invalid { file: name.to_owned(), violation };
        if let Cloth::Grid(grid) = &scene.cloth {
            check_count(u64::from(grid.rows) * u64::from(grid.columns)).map_err(invalid)?;
        }
        let of = scene.material.as_ref().and_then(|material| material.of.as_deref());
        if let Some(of) = of.filter(|of| Material::text(of).is_none()) {
            let known: Vec<_> = Material::bundled().collect();
            let expected = format!(
                "one of {}, or the constants of the material in the scene: the lab reads no table",
                known.join(", ")
            );
            return Err(invalid(refuse("material.of", quoted(of), expected)).into());
        }
        match &scene.cloth {
            Cloth::Mesh(mesh) if !mesh.file.starts_with("bundled:") => {
                Ok(self.with_mesh(name, text, scene)?)
            }
            _ => Ok(plain(drape_model::parse(name, text)?)),
        }
    }

    /// A scene whose mesh was given before.
    fn with_mesh(&self, name: &str, text: &str, mut scene: Scene) -> Result<Dropped, SceneError> {
        let invalid = |violation| SceneError::Invalid { file: name.to_owned(), violation };
        check_keys(name, text)?;
        let Cloth::Mesh(mesh) = &mut scene.cloth else {
            return Err(invalid(refuse("cloth", "no mesh", "a mesh")));
        };
        // A scene may lie beside its mesh or in a folder above it, but a page has no folders.
        let file = mesh.file.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
        let Some(bytes) = self.meshes.get(&file) else {
            let expected = format!("a mesh that this page was given: drop {file} together with it");
            return Err(invalid(refuse("cloth.mesh.file", quoted(&mesh.file), expected)));
        };
        mesh.file.clone_from(&file);
        mesh.read(&**bytes).map_err(invalid)?;
        let notes = mesh.repairs().to_vec();
        Ok(Dropped {
            source: Source::Scene(Box::new(scene)),
            mesh: Some(file),
            is_scene: true,
            notes,
        })
    }
}

fn of_file(file: SceneFile) -> Source {
    match file {
        SceneFile::Scene(scene, _) => Source::Scene(scene),
        SceneFile::System(spec) => Source::System(Box::new(spec)),
    }
}

fn text<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str, SceneError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let valid = &bytes[..error.valid_up_to()];
        let last = valid.rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
        SceneError::Syntax {
            file: name.to_owned(),
            line: 1 + valid.iter().filter(|&&byte| byte == b'\n').count(),
            column: 1 + last.len(),
            path: ".".to_owned(),
            reason: "not UTF-8".to_owned(),
            found: format!("byte 0x{:02x}", bytes[valid.len()]),
        }
    })
}

/// Checks the keys of a scene as `drape run` does, without its mesh. To do so, it reads the text
/// with the name of a bundled mesh that does not exist in place of the file.
fn check_keys(name: &str, text: &str) -> Result<(), SceneError> {
    type Keys<'a> = BTreeMap<String, &'a RawValue>;
    let inside = |text: &'_ str, key: &str| -> Option<(usize, usize)> {
        let keys: Keys<'_> = serde_json::from_str(text).ok()?;
        let raw = keys.get(key)?.get();
        // `raw` is a part of `text`.
        let start = raw.as_ptr() as usize - text.as_ptr() as usize;
        Some((start, start + raw.len()))
    };
    let mut place = (0, text.len());
    for key in ["cloth", "mesh", "file"] {
        let found = inside(&text[place.0..place.1], key);
        let Some((start, end)) = found else { return Ok(()) };
        place = (place.0 + start, place.0 + end);
    }
    let without = format!("{}\"bundled:\"{}", &text[..place.0], &text[place.1..]);
    match drape_model::parse(name, &without) {
        Err(error @ (SceneError::Syntax { .. } | SceneError::Shape { .. })) => Err(error),
        _ => Ok(()),
    }
}

/// A cloth from a mesh without a scene. It hangs by those of its highest particles that have the
/// least and the greatest `x`.
fn of_mesh(name: &str, bytes: &[u8]) -> Result<Dropped, SceneError> {
    let invalid = |violation| SceneError::Invalid { file: name.to_owned(), violation };
    let mut mesh = MeshCloth::of_file(name);
    mesh.areal_density_kg_m2 = Some(DENSITY_KG_M2);
    mesh.read(bytes).map_err(invalid)?;
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let tension = SpringLaw {
        stiffness_over_mass_per_s2: Some(STIFFNESS_PER_S2),
        damping_over_mass_per_s: Some(DAMPING_PER_S),
        ..SpringLaw::default()
    };
    let mut scene = Scene {
        format: "drape-scene/1".to_owned(),
        name: stem.to_owned(),
        description: format!("The mesh {name}, held by its highest particles."),
        assumed: ASSUMED.map(str::to_owned).to_vec(),
        cloth: Cloth::Mesh(mesh),
        material: None,
        effects: Effects {
            tension: Some(tension),
            gravity: Some(GravitySpec { m_s2: [0.0, 0.0, -GRAVITY_M_S2] }),
            ..Effects::default()
        },
        damping: DampingLaw::default(),
        pins: Vec::new(),
        obstacles: Vec::new(),
        time: TIME,
    };
    let spec = scene.discretise().map_err(invalid)?;
    scene.pins = highest(&spec.particles.position_m)
        .into_iter()
        .map(|particle| Pin { particle: Some(particle), ..Pin::default() })
        .collect();
    let notes = vec![format!(
        "the mesh {name} is taken as cloth of {DENSITY_KG_M2} kg/m² in metres, with k/m = \
         {STIFFNESS_PER_S2} 1/s² along all edges and gravity, held by its highest particles"
    )];
    let source = Source::Scene(Box::new(scene));
    Ok(Dropped { source, mesh: Some(name.to_owned()), is_scene: false, notes })
}

/// The highest particle with the least `x` and the one with the greatest `x`. Of several such
/// particles, the first.
fn highest(places: &[[f64; 3]]) -> Vec<u32> {
    let heights = || places.iter().map(|x| x[2]);
    let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::MIN, f64::max));
    let size: Vec3 = places.iter().fold(Vec3::zeros(), |size, &x| size.sup(&Vec3::from(x).abs()));
    let bound = high - LEVEL * (high - low).max(size.amax());
    // In a flat cloth all particles are equally high, and so is the lower edge in y.
    let top = || (0_u32..).zip(places).filter(|(_, x)| x[2] >= bound);
    let by = |sign: f64| {
        let key = |x: &[f64; 3]| (sign * x[0], x[1]);
        let found = top().min_by(|(_, a), (_, b)| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        found.map(|(particle, _)| particle)
    };
    let mut pins: Vec<u32> = [by(1.0), by(-1.0)].into_iter().flatten().collect();
    pins.dedup();
    pins
}

/// Refuses more particles than a pane may have.
pub(crate) fn check_count(found: u64) -> Result<(), Violation> {
    if found <= limits::PARTICLES as u64 {
        return Ok(());
    }
    let expected = format!("at most {} particles", limits::PARTICLES);
    Err(refuse("cloth", format!("{found} particles"), expected))
}

/// Discretises a scene once, so that its faults show when it is dropped.
fn check_size(name: &str, source: &Source) -> Result<(), SceneError> {
    let invalid = |violation| SceneError::Invalid { file: name.to_owned(), violation };
    let spec = source.spec().map_err(invalid)?;
    check_count(spec.particles.mass_kg.len() as u64).map_err(invalid)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3 4\n";

    fn refused(name: &str, bytes: &[u8]) -> String {
        Files::default().add(name, bytes).unwrap_err().to_string()
    }

    #[test]
    fn a_mesh_alone_hangs_by_its_upper_corners() {
        let mut files = Files::default();
        let dropped = files.add("square.obj", SQUARE.as_bytes()).unwrap();
        let Source::Scene(scene) = &dropped.source else { panic!("a scene") };
        let pins: Vec<_> = scene.pins.iter().map(|pin| pin.particle.unwrap()).collect();
        assert_eq!(pins, [3, 2]);
        assert_eq!(scene.assumed.len(), ASSUMED.len());
        assert!(dropped.notes[0].contains("0.2 kg/m²"), "{:?}", dropped.notes);
    }

    #[test]
    fn a_faulty_file_is_named_with_place_and_value() {
        let broken = SQUARE.replace("f 1 2 3 4", "f 1 2 3 9");
        let scene = |cloth: &str| {
            format!(
                r#"{{ "format": "drape-scene/1", "name": "x", "cloth": {cloth},
                    "time": {{ "step_s": 0.01, "duration_s": 1 }} }}"#
            )
        };
        let grid = |rows: u32| {
            scene(&format!(
                r#"{{ "grid": {{ "rows": {rows}, "columns": 200, "size_m": [1, 1],
                    "center_m": [0, 0, 0], "mass_kg": 1 }} }}"#
            ))
        };
        let mesh = |file: &str| {
            scene(&format!(r#"{{ "mesh": {{ "file": {file:?}, "areal_density_kg_m2": 0.1 }} }}"#))
        };
        let misspelt = mesh("a.obj").replace("areal", "aerial");
        let material = grid(3).replace("\"time\"", "\"material\": \"/etc/passwd\", \"time\"");
        for (name, text, parts) in [
            ("a.obj", broken.as_str(), &["a.obj", "line 5", "9"][..]),
            ("a.json", "{ \"format\": ", &["a.json", "line 1"]),
            ("a.json", "{ \"format\": \"no\" }", &["a.json", "format", "drape-scene/1"]),
            ("a.json", &grid(20_000), &["a.json", "4000000 particles", "at most 10000"]),
            ("a.json", &mesh("/etc/passwd"), &["cloth.mesh.file", "/etc/passwd", "drop passwd"]),
            ("a.json", &mesh("../b.obj"), &["cloth.mesh.file", "../b.obj", "drop b.obj"]),
            ("a.json", &misspelt, &["aerial_density_kg_m2", "unknown key"]),
            ("a.json", &material, &["material.of", "/etc/passwd", "no table"]),
            ("a.csv", "1,2,3", &["a.csv", ".json", ".obj"]),
            ("../a.obj", SQUARE, &["../a.obj", "without a folder"]),
            ("-a.obj", SQUARE, &["-a.obj"]),
        ] {
            let error = refused(name, text.as_bytes());
            for part in parts {
                assert!(error.contains(part), "{name}: {part} is missing: {error}");
            }
        }
        assert!(refused("a.json", b"{ \"a\": \xff }").contains("not UTF-8"));
        let long = vec![b'#'; limits::MESH_BYTES + 1];
        assert!(refused("long.obj", &long).contains("bytes long"));
    }

    #[test]
    fn a_scene_takes_its_mesh_from_the_files_of_the_page_and_from_nowhere_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.obj");
        std::fs::write(&path, SQUARE).unwrap();
        let text = format!(
            r#"{{ "format": "drape-scene/1", "name": "x",
                "cloth": {{ "mesh": {{ "file": {path:?}, "areal_density_kg_m2": 0.1 }} }},
                "time": {{ "step_s": 0.01, "duration_s": 1 }} }}"#
        );
        let mut files = Files::default();
        assert!(drape_model::parse("x.json", &text).is_ok(), "the file is there");
        let error = files.add("x.json", text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("drop square.obj together with it"), "{error}");
        files.add("square.obj", SQUARE.as_bytes()).unwrap();
        let dropped = files.add("x.json", text.as_bytes()).unwrap();
        assert_eq!(dropped.mesh.as_deref(), Some("square.obj"));
        assert!(dropped.is_scene);
    }

    #[test]
    fn a_page_may_give_so_many_files() {
        let mut files = Files::default();
        for n in 0..limits::FILES {
            files.add(&format!("{n}.obj"), SQUARE.as_bytes()).unwrap();
        }
        assert!(files.add("more.obj", SQUARE.as_bytes()).is_err());
        files.add("0.obj", SQUARE.as_bytes()).unwrap();
    }
}
