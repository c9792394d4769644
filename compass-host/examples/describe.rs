//! Describes a place of a floor plan as the paper does: 360 ranges, hit types and five channels.
//!
//! ```text
//! cargo run --release -p compass-host --example describe -- PLAN X Y HEADING
//! ```
//!
//! PLAN is an image, dark = wall and red = glazing, of 0.01 m per pixel; X and Y are metres from its lower left
//! corner, HEADING is in degrees counter-clockwise from +x. Prints every tenth bin and the key figures.

use compass_host::plan_descriptor::hit_name;
use compass_host::{PackedPlan, PlanDescriptor, PlanOptions, load_plan};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [plan, x, y, heading] = &arguments[..] else {
        return Err("usage: describe PLAN X Y HEADING".into());
    };

    let raster = load_plan(&PlanOptions::new(plan))?;
    let scan = PackedPlan::new(&raster)?.scan([x.parse()?, y.parse()?], heading.parse()?)?;
    let described = PlanDescriptor::from(&scan);

    println!("bearing  range (m)  hit     channels");
    for bin in (0..360).step_by(10) {
        let channels = described.channels.map(|channel| format!("{:.3}", channel[bin])).join(" ");
        let (range, hit) = (described.range_m[bin], hit_name(described.hit[bin]));
        println!("{bin:7}  {range:9.2}  {hit:6}  {channels}");
    }
    let stats = described.stats();
    println!(
        "{:.2} to {:.2} m, {} bins of glazing, {} open",
        stats.range_min_m, stats.range_max_m, stats.window_bins, stats.open_bins
    );
    Ok(())
}
