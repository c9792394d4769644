//! `compass plan`: what was understood of a plan, before anything is built on it.

use super::exit::Outcome;
use super::json::JsonOption;
use super::pictures::with_plan;
use super::plan::{PlanArgs, finite};
use anyhow::{Context as _, Result};
use compass_host::figures::{PlanSurveyPicture, draw_plan_survey};
use compass_host::interior::{self, CLEARANCE_M, Interior, InteriorOptions};
use compass_host::output::Decimal;
use compass_host::plan_export::export;
use compass_host::plan_import::structure::DEFAULT_THICKNESS_M;
use compass_host::plan_import::{Imported, LayerRole, PlanRaster, survey};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct ShowPlan {
    #[command(flatten)]
    plan: PlanArgs,
    /// Write the picture to FILE, as PNG
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write the plan into DIR for other programs: walls.png, plan.png with glazing in red, map.yaml for ROS
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// Distance between the candidates of the picture in metres
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = finite, allow_hyphen_values = true)]
    spacing: f64,
    #[command(flatten)]
    json: JsonOption,
}

#[derive(Debug, Serialize)]
struct Output {
    width_m: Decimal,
    height_m: Decimal,
    resolution_m: Decimal,
    origin: [Decimal; 2],
    area_m2: Option<Decimal>,
    max_gap_m: Option<Decimal>,
    candidates: usize,
    wall_m: Decimal,
    glazing_m: Decimal,
    wall_thickness: Vec<Thickness>,
    structure: bool,
    door_count: Option<usize>,
    layers: Vec<LayerOutput>,
    ignored: usize,
    suspicious: usize,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Thickness {
    from_m: Decimal,
    to_m: Option<Decimal>,
    length_m: Decimal,
}

#[derive(Debug, Serialize)]
struct LayerOutput {
    name: String,
    entities: usize,
    hidden: usize,
    annotations: usize,
    role: Option<&'static str>,
}

/// What the interior of the plan is, or why there is none.
type Inside = Result<(Interior, Vec<[f64; 2]>), String>;

impl ShowPlan {
    pub(super) fn run(&self) -> Result<Outcome> {
        let imported = self.plan.import(self.picture.is_some())?;
        let inside = self.inside(&imported.plan);
        let suspects: Vec<([f64; 2], f64)> =
            survey::specks(&imported.plan).iter().map(|speck| (speck.position, speck.radius_m)).collect();
        let output = output(&imported, &inside, suspects.len());
        let text = summary(&output);
        if let Some(path) = &self.picture {
            let structure = imported.structure(DEFAULT_THICKNESS_M, &self.plan.places()).ok();
            draw(path, &imported, structure.as_ref(), &inside, &suspects, &caption(&output))?;
        }
        if let Some(dir) = &self.export {
            export(dir, &imported.plan)?;
        }
        self.json.emit(&output, &text)?;
        Ok(Outcome::Done)
    }

    fn inside(&self, plan: &PlanRaster) -> Inside {
        let (walls, windows) = (plan.walls_mask(), plan.windows_mask());
        let options = InteriorOptions::with_places(self.plan.places(), plan.origin);
        let found = interior::find(&walls, &windows, plan.resolution_m, &options);
        let found = found.map_err(|error| error.to_string())?;
        let cells = found.candidates(&walls, &windows, self.spacing, CLEARANCE_M);
        let position = |[column, row]: [u16; 2]| {
            let metres =
                |cell: u16, axis: usize| plan.origin[axis] + (f64::from(cell) + 0.5) * plan.resolution_m;
            [metres(column, 0), metres(row, 1)]
        };
        let positions = cells.map_err(|error| error.to_string())?.into_iter().map(position).collect();
        Ok((found, positions))
    }
}

fn output(imported: &Imported, inside: &Inside, suspicious: usize) -> Output {
    let plan = &imported.plan;
    let walls = survey::wall_thickness(plan);
    let side = |pixels: u32| Decimal(f64::from(pixels) * plan.resolution_m);
    let thickness = walls.iter().map(|class| Thickness {
        from_m: Decimal(class.from_m),
        to_m: class.to_m.is_finite().then_some(Decimal(class.to_m)),
        length_m: Decimal(class.length_m),
    });
    let layers = imported.layers.iter().map(|layer| LayerOutput {
        name: layer.name.clone(),
        entities: layer.entities,
        hidden: layer.hidden,
        annotations: layer.annotations,
        role: layer.role.map(LayerRole::name),
    });
    let left_out = imported.layers.iter().map(|layer| {
        let shown = layer.role.is_some_and(|role| role != LayerRole::Ignored);
        layer.hidden + layer.annotations + if shown { 0 } else { layer.entities }
    });
    let found = inside.as_ref().ok();
    let notes = imported.notes.iter().map(ToString::to_string);
    Output {
        width_m: side(plan.width),
        height_m: side(plan.height),
        resolution_m: Decimal(plan.resolution_m),
        origin: plan.origin.map(Decimal),
        area_m2: found.map(|(interior, _)| Decimal(interior.area_m2())),
        max_gap_m: found.map(|(interior, _)| Decimal(interior.max_gap_m())),
        candidates: found.map_or(0, |(_, candidates)| candidates.len()),
        wall_m: Decimal(survey::length_m(&walls)),
        glazing_m: Decimal(survey::length_m(&survey::glazing_thickness(plan))),
        wall_thickness: thickness.collect(),
        structure: imported.has_structure(),
        door_count: imported.doors.as_ref().map(survey::piece_count),
        layers: layers.collect(),
        ignored: left_out.sum(),
        suspicious,
        warnings: notes.chain(inside.as_ref().err().cloned()).collect(),
    }
}

fn caption(output: &Output) -> String {
    let area = output.area_m2.map_or("no interior found".into(), |area| format!("interior {:.0} m²", area.0));
    format!(
        "{:.1} x {:.1} m, {area}, {:.0} m of wall, {:.0} m of glazing",
        output.width_m.0, output.height_m.0, output.wall_m.0, output.glazing_m.0
    )
}

fn summary(output: &Output) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "size           {:.2} x {:.2} m from {}, {} at {} m per pixel",
        output.width_m.0, output.height_m.0, output.origin[0].0, output.origin[1].0, output.resolution_m.0
    );
    let _ = match output.area_m2.zip(output.max_gap_m) {
        Some((area, gap)) => writeln!(
            text,
            "interior       {:.1} m2, {} candidates; openings up to {} m count as closed",
            area.0, output.candidates, gap.0
        ),
        None => writeln!(text, "interior       none"),
    };
    let (walls, glazing) = (output.wall_m.0, output.glazing_m.0);
    let share = 100.0 * glazing / (walls + glazing).max(f64::MIN_POSITIVE);
    let _ = writeln!(text, "walls          {walls:.1} m, glazing {glazing:.1} m ({share:.0} %)");
    for class in output.wall_thickness.iter().filter(|class| class.length_m.0 >= 0.05) {
        let to = class.to_m.map_or("more".into(), |to| format!("{:.2} m", to.0));
        let _ = writeln!(text, "  {:.2} to {to:<7} {:8.1} m", class.from_m.0, class.length_m.0);
    }
    if let Some(doors) = output.door_count {
        let _ = writeln!(text, "doors          {doors}, open");
    }
    if output.suspicious > 0 {
        let _ = writeln!(
            text,
            "suspicious     {} small pieces that stand alone, such as letters",
            output.suspicious
        );
    }
    if !output.layers.is_empty() {
        let _ = writeln!(text, "layers");
    }
    for layer in &output.layers {
        let role = layer.role.unwrap_or("not recognised, left out");
        let _ = writeln!(
            text,
            "  {:<28} {:6} drawn, {:5} hidden, {:5} annotations: {role}",
            layer.name, layer.entities, layer.hidden, layer.annotations
        );
    }
    text
}

fn draw(
    path: &std::path::Path,
    imported: &Imported,
    structure: Option<&PlanRaster>,
    inside: &Inside,
    suspects: &[([f64; 2], f64)],
    caption: &str,
) -> Result<()> {
    let interior = inside.as_ref().ok();
    let is_structure = |x: u32, y: u32| structure.is_some_and(|structure| structure.is_wall(x, y));
    let is_door = |x: u32, y: u32| imported.doors.as_ref().is_some_and(|doors| doors.is_wall(x, y));
    let is_left_out = |x: u32, y: u32| imported.left_out.as_ref().is_some_and(|other| other.is_wall(x, y));
    let is_inside = |x: u32, y: u32| interior.is_some_and(|(interior, _)| interior.is_inside_px(x, y));
    let picture = PlanSurveyPicture {
        is_structure: structure.is_some().then_some(&is_structure),
        is_door: imported.doors.is_some().then_some(&is_door),
        is_left_out: imported.left_out.is_some().then_some(&is_left_out),
        is_inside: interior.is_some().then_some(&is_inside),
        candidates: interior.map_or(&[], |(_, candidates)| candidates),
        suspects,
    };
    with_plan(&imported.plan, |plan| draw_plan_survey(path, plan, &picture, caption))
        .with_context(|| path.display().to_string())
}
