use drape_harness::methods::Choice;
use drape_integrator::{PhaseClock, TimeStep};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut input = drape_model::load(&args[1]).unwrap();
    let h: f64 = args[3].parse().unwrap();
    let t: f64 = args[4].parse().unwrap();
    if let (drape_model::Input::Scene(s, spec), Some(km)) = (&mut input, args.get(5)) {
        let km: f64 = km.parse().unwrap();
        s.effects.tension.as_mut().unwrap().stiffness_over_mass_per_s2 = Some(km);
        if let Some(sh) = s.effects.shear.as_mut() { sh.stiffness_over_mass_per_s2 = Some(0.1*km); }
        *spec = s.discretise().unwrap();
    }
    let (system, mut state) = input.spec().build().unwrap();
    let n = (system.len() as f64).sqrt() as usize;
    let tracked = (n - 1) * n + n / 2;
    let choice = Choice::parse(&args[2], &[]).unwrap();
    let mut m = choice.build().unwrap();
    let ts = TimeStep::new(h).unwrap();
    m.prepare(&system, ts).unwrap();
    let (mut cg, mut outer, mut newton, mut mv, mut fe) = (0u64, 0u64, 0u64, 0u64, 0u64);
    let e0 = system.total_energy(&state);
    let (mut gain, mut rises) = (0.0f64, 0);
    let mut last = e0;
    let mut secs = 0.0;
    let steps = (t / h).round() as usize;
    let mut bad = 0;
    for _ in 0..steps {
        let a = std::time::Instant::now();
        let r = m.step(&system, &mut state, ts, &mut PhaseClock::off()).unwrap();
        secs += a.elapsed().as_secs_f64();
        cg += r.cg_iterations as u64; outer += r.outer_passes as u64; newton += r.newton_iterations as u64;
        mv += r.matvecs as u64; fe += r.force_evaluations as u64;
        if r.solve != drape_integrator::SolveStatus::Converged { bad += 1; }
        let e = system.total_energy(&state);
        gain = gain.max(e - e0);
        if e > last + 1e-9 { rises += 1; }
        last = e;
    }
    println!("{:<60} steps {steps} cg {cg} outer {outer} newton {newton} mv {mv} fe {fe} gain {gain:.3e} rises {rises} bad {bad} z {:.4} us/step {:.1}", args[2], state.x[tracked].z, secs / steps as f64 * 1e6);
}
