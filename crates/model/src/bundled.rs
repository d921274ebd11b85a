//! The scenes and meshes that come with drape.

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name, ".json")))),+]
    };
}

/// Name and text of each, in the order in which they are listed.
static SCENES: &[(&str, &str)] = scenes![
    "hanging-textile-1e4",
    "hanging-textile-1e6",
    "hanging-textile-sheared-1e4",
    "hanging-textile-sheared-1e6",
    "square-table-1e4",
    "square-table-1e4-h02",
    "square-table-1e6-h005",
    "square-table-2704-1e6",
    "round-table",
    "flag",
    "sheet-on-sphere",
    "curtain",
    "skirt",
    "spinning-sheet",
    "drape-test",
    "hanging-wool",
    "hanging-denim",
    "oscillator",
    "loaded-spring",
];

macro_rules! meshes {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../scenes/", $name)))),+]
    };
}

/// Name and OBJ text of each mesh.
static MESHES: &[(&str, &str)] = meshes!["round-cloth.obj", "skirt.obj", "sheet.obj"];

/// Names of the bundled meshes, which a scene names as `bundled:NAME`.
pub fn meshes() -> impl Iterator<Item = &'static str> {
    MESHES.iter().map(|(name, _)| *name)
}

/// The OBJ text of a bundled mesh; `None` for an unknown name.
pub fn mesh(name: &str) -> Option<&'static str> {
    MESHES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// Names of the bundled scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|(name, _)| *name)
}

/// The JSON text of a bundled scene; `None` for an unknown name.
pub fn text(name: &str) -> Option<&'static str> {
    SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}
