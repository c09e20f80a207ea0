//! `midway bench`, as far as it is the same on every machine.

use crate::support::Sandbox;

#[test]
fn the_baseline_renders_the_same_image_with_as_many_rays() {
    let sandbox = Sandbox::new();
    sandbox.write_scene();
    let small =
        ["--device", "cpu", "--width", "16", "--height", "12", "--spp", "4", "--rounds", "2", "--json"];
    let run = sandbox.expect(0, &[&["bench", "baseline", "scene.obj"][..], &small].concat());
    let row = &run.json_lines()[0]["rows"][0];
    assert_eq!(row["mean_ratio"], 1.0);
    let [queues, one_kernel] = ["queues", "one_kernel"].map(|form| row[form]["rays"].as_u64().unwrap());
    assert!(queues == one_kernel && queues > 16 * 12 * 4, "{queues}, {one_kernel}");
    let ratio = row["queues"]["msamples_per_second"].as_f64().unwrap()
        / row["one_kernel"]["msamples_per_second"].as_f64().unwrap();
    assert!((ratio - row["speed_ratio"].as_f64().unwrap()).abs() <= 1e-9 * ratio);
}
