//! Specimens of textile tests, and rows of tables as materials.

use drape_model::fabric::{Material, MaterialChoice, Table, TriangleStrip};

#[test]
fn a_strip_of_triangles_is_equilateral_and_held_at_its_clamp() {
    let material = MaterialChoice::named("denim");
    let strip = TriangleStrip { length_m: 0.1, segments: 10, rows: 4, material };
    let scene = strip.scene().expect("a mesh");
    let spec = scene.discretise().expect("a valid strip");
    let x = &spec.particles.position_m;
    // Two rows with 12 particles, two with 13.
    assert_eq!(x.len(), 2 * (12 + 13));
    let held: Vec<usize> = spec.pins.iter().map(|pin| pin.particle as usize).collect();
    for (i, x) in x.iter().enumerate() {
        let is_behind = x[0] < 0.51 * strip.spacing_m();
        assert_eq!(held.contains(&i), is_behind, "{x:?}");
    }
    let end = x.iter().filter(|x| (x[0] - 0.1).abs() < 1e-12).count();
    assert_eq!(end, 4, "the free end is straight");
    // Whole triangles have three edges of one length; those at the ends are halves.
    let length = |a: u32, b: u32| {
        let [a, b] = [x[a as usize], x[b as usize]];
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let is_whole = |t: &&[u32; 3]| {
        [length(t[0], t[1]), length(t[1], t[2]), length(t[2], t[0])]
            .iter()
            .all(|edge| (edge / strip.spacing_m() - 1.0).abs() < 1e-9)
    };
    let whole = spec.triangles.iter().filter(is_whole).count();
    assert_eq!((spec.triangles.len(), whole), (3 * 23, 3 * 21));
    let mass: f64 = spec.particles.mass_kg.iter().sum();
    let area = (0.1 + strip.spacing_m()) * strip.width_m();
    assert!((mass / (0.324 * area) - 1.0).abs() < 1e-9, "{mass}");
    let gamma = strip.gamma().expect("a material");
    assert!((gamma - 0.324 * 9.81 * 1e-3 / (0.5 * (6.094e-5 + 1.078e-4))).abs() < 1e-9, "{gamma}");
}

#[test]
fn a_row_of_a_table_takes_what_it_lacks_from_another_material() {
    let text = "density[kg.m-2],linear warp[SI*1e9],linear weft[SI*1e9]\n0.15,12500,3000\n";
    let row = Table::parse(text, "table").expect("a table").row(1, "row").expect("a row");
    let denim = Material::load("denim").expect("bundled");
    let material = row.material("mine", "Row 1", &denim);
    assert_eq!(material.areal_density_kg_m2, 0.15);
    assert_eq!(material.bending_n_m, row.bending_n_m);
    assert_eq!(material.tension_n_per_m, denim.tension_n_per_m);
    assert_eq!(material.assumed.len(), 3);
    assert!(material.source.starts_with("Row 1.") && material.source.contains("those of denim"));
    let missing = Table::load("nowhere.csv").expect_err("no such file");
    assert!(missing.to_string().contains("nowhere.csv"), "{missing}");
}
