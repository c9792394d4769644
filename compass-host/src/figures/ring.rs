//! The levelled panorama with the windows found in it, and the hit type of every direction below.

use std::path::Path;

use compass_core::base::num::LogOdds;
use compass_core::base::raster::GrayImage;
use compass_core::base::scan::Hit;
use compass_core::vision::panorama::{Resolution, TOP_DEG};
use compass_core::vision::windows::{Edge, Window, WindowBox};
use plotters::style::RGBColor;

use super::canvas::{CENTRE, Canvas, LEFT, RIGHT, Rect};
use super::error::{Drawn, FigureError};
use super::overlay::Notes;
use super::page::{Entry, Page, Symbol};
use super::style::{INK, Pen, TICK_PX, UNKNOWN, WALL, WINDOW, number};

/// The contents of the panorama picture.
#[derive(Debug, Clone, Copy)]
pub struct RingPicture<'a> {
    /// The panorama in gray, 0 where a cell is unobserved.
    pub ring: GrayImage<'a>,
    /// Its resolution.
    pub resolution: Resolution,
    /// The selected windows.
    pub windows: &'a [Window],
    /// The boxes from which they were selected.
    pub boxes: &'a [WindowBox],
    /// The edges that bound the boxes.
    pub edges: &'a [Edge],
    /// Hit type by bin.
    pub hit: &'a [Hit; 360],
    /// Which bins were observed.
    pub known: &'a [bool; 360],
}

/// Boxes below this score are not drawn.
const LEAST: LogOdds = LogOdds::lit("-1");
/// Space to the left of the panorama for the elevations.
const BESIDE: f64 = 76.0;
/// Space above each half, and below the lower.
const BETWEEN: f64 = 30.0;
/// Height of the ticks of edges, of the azimuths and of the hits below a half.
const TICKS: f64 = 34.0;
const AZIMUTHS: f64 = 40.0;
const HITS: f64 = 44.0;

const CHOSEN: RGBColor = RGBColor(0xf0, 0x30, 0x20);
const CONSIDERED: RGBColor = RGBColor(0x30, 0xa0, 0xff);
const EDGE: RGBColor = RGBColor(0x10, 0x90, 0x40);
const HORIZON: RGBColor = RGBColor(0xff, 0xd0, 0x00);

/// Draws the half of the panorama ahead, below it the half behind, and below each its hits.
///
/// # Errors
/// [`FigureError`] when the file cannot be written.
pub fn draw_ring(path: &Path, data: &RingPicture<'_>) -> Result<(), FigureError> {
    let considered = data.boxes.iter().filter(|b| is_shown(b)).count();
    let bins = |hit: Hit| data.known.iter().zip(data.hit).filter(|(k, h)| **k && **h == hit).count();
    let unseen = data.known.iter().filter(|known| !**known).count();
    let line = |colour, width| Symbol::Line(Pen::solid(colour, width));
    let legend = vec![
        Entry::new(line(CHOSEN, 6.0), format!("windows, with log odds ({})", data.windows.len())),
        Entry::new(line(CONSIDERED, 2.0), format!("boxes above {} nat ({considered})", number(-1.0))),
        Entry::new(line(EDGE, 3.0), format!("edges ({})", data.edges.len())),
        Entry::new(line(HORIZON, 3.0), "horizon"),
        Entry::new(Symbol::Patch(WINDOW), format!("window ({})", bins(Hit::Window))),
        Entry::new(Symbol::Patch(WALL), format!("wall ({})", bins(Hit::Wall))),
        Entry::new(Symbol::Patch(UNKNOWN), format!("not seen ({unseen})")),
    ];
    let height = half_height(data.resolution) + TICKS + AZIMUTHS + HITS;
    let page = Page {
        path,
        caption: "The levelled ring, ahead (above) and behind (below): brightness rank by azimuth and elevation",
        legend,
        body: 2.0 * height + 3.0 * BETWEEN,
    };
    page.draw(|canvas, body| {
        for (n, middle_deg) in [0, -180].into_iter().enumerate() {
            let top = body.top + BETWEEN + n as f64 * (height + BETWEEN);
            let frame = Rect {
                left: body.left + BESIDE,
                top,
                right: body.right,
                bottom: top + half_height(data.resolution),
            };
            Half { data, frame, from_deg: middle_deg + 90 }.draw(canvas)?;
        }
        Ok(())
    })
}

/// Half of the panorama is as wide as the page.
fn half_height(resolution: Resolution) -> f64 {
    let columns = resolution.columns() / 2;
    (Page::INNER_WIDTH - BESIDE) * resolution.rows() as f64 / columns as f64
}

fn is_shown(b: &WindowBox) -> bool {
    b.score() > LEAST
}

/// 180 degrees of the panorama, clockwise from an azimuth.
struct Half<'a> {
    data: &'a RingPicture<'a>,
    frame: Rect,
    from_deg: i32,
}

impl Half<'_> {
    /// Pixels per cell.
    fn cell(&self) -> f64 {
        2.0 * self.frame.width() / self.data.resolution.columns() as f64
    }

    /// The panorama's column at the left end.
    fn first_column(&self) -> f64 {
        f64::from(180 - self.from_deg) * self.data.resolution.per_degree() as f64
    }

    /// The pixel columns between two of the panorama's columns, clipped to this half; the second may lie beyond the
    /// panorama's last.
    fn span(&self, [start, end]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        let (turn, frame, cell) = (self.data.resolution.columns() as f64, self.frame, self.cell());
        let first = self.first_column();
        [-turn, 0.0, turn].into_iter().filter_map(move |by| {
            let place = |column: f64| frame.left + (column + by - first) * cell;
            let (left, right) = (place(start).max(frame.left), place(end).min(frame.right));
            (left <= right).then_some([left, right])
        })
    }

    fn y_px(&self, row: f64) -> f64 {
        self.frame.top + row * self.cell()
    }

    fn row_of(&self, elevation_deg: i32) -> f64 {
        f64::from(TOP_DEG - elevation_deg) * self.data.resolution.per_degree() as f64
    }

    fn draw(&self, canvas: &Canvas<'_>) -> Drawn {
        self.draw_gray(canvas)?;
        let horizon = self.y_px(self.row_of(0));
        let frame = self.frame;
        canvas.line(&[[frame.left, horizon], [frame.right, horizon]], Pen::solid(HORIZON, 1.5))?;
        for b in self.data.boxes.iter().filter(|b| is_shown(b)) {
            self.draw_box(canvas, b.columns(), b.rows(), Pen::solid(CONSIDERED, 1.0))?;
        }
        for w in self.data.windows {
            self.draw_box(canvas, w.columns, w.rows, Pen::solid(CHOSEN, 5.0))?;
        }
        let mut notes = Notes::new(frame);
        for w in self.data.windows {
            for [left, right] in self.span(w.columns.map(f64::from)).filter(|[l, r]| r - l > 4.0) {
                let text = format!("{:.1}", f64::from(w.score)).replace('-', "\u{2212}");
                let at = [(left + right) / 2.0, self.y_px(f64::from(w.rows[0]))];
                notes.write(canvas, at, &text)?;
            }
        }
        self.draw_scale(canvas)?;
        self.draw_hits(canvas)
    }

    fn draw_gray(&self, canvas: &Canvas<'_>) -> Drawn {
        let (columns, cell) = (self.data.resolution.columns(), self.cell());
        let (frame, first) = (self.frame, self.first_column() as usize);
        canvas.paint(frame, |square| {
            let [x, y] = square.centre();
            let column = (first + ((x - frame.left) / cell) as usize) % columns;
            let row = self.data.ring.row(((y - frame.top) / cell) as usize);
            Some(row.get(column).filter(|rank| **rank > 0).map_or(UNKNOWN, |&g| RGBColor(g, g, g)))
        })
    }

    fn draw_box(&self, canvas: &Canvas<'_>, columns: [u16; 2], rows: [u16; 2], pen: Pen) -> Drawn {
        let [top, bottom] = rows.map(|row| self.y_px(f64::from(row)));
        for [left, right] in self.span(columns.map(f64::from)) {
            canvas.outline(Rect { left, top, right, bottom }, pen)?;
        }
        Ok(())
    }

    /// Edges, elevations, and azimuths every 10 degrees.
    fn draw_scale(&self, canvas: &Canvas<'_>) -> Drawn {
        let frame = self.frame;
        for edge in self.data.edges {
            let column = f64::from(edge.column());
            for [x, _] in self.span([column, column]) {
                canvas.line(
                    &[[x, frame.bottom + 4.0], [x, frame.bottom + TICKS - 6.0]],
                    Pen::solid(EDGE, 3.0),
                )?;
            }
        }
        for elevation in (-30..=30).step_by(10) {
            let y = self.y_px(self.row_of(elevation));
            canvas.line(&[[frame.left - 8.0, y], [frame.left, y]], Pen::solid(INK, 2.0))?;
            let text = format!("{}°", number(f64::from(elevation)));
            canvas.text([frame.left - 12.0, y], TICK_PX, RIGHT, &text)?;
        }
        for turn in (0..=180).step_by(10) {
            let azimuth = (self.from_deg - turn + 540).rem_euclid(360) - 180;
            let x = frame.left + f64::from(turn) / 180.0 * frame.width();
            let top = frame.bottom + TICKS;
            canvas.line(&[[x, frame.bottom], [x, top]], Pen::solid(INK, 1.0))?;
            let text = number(f64::from(azimuth));
            let x = x.min(frame.right - 22.0);
            canvas.text([x, top + AZIMUTHS / 2.0], TICK_PX, CENTRE, &text)?;
        }
        canvas.text([frame.left - BESIDE, frame.bottom + TICKS + AZIMUTHS / 2.0], TICK_PX, LEFT, "az.")?;
        canvas.outline(frame, Pen::solid(INK, 2.0))
    }

    fn draw_hits(&self, canvas: &Canvas<'_>) -> Drawn {
        let top = self.frame.bottom + TICKS + AZIMUTHS;
        let bar = Rect { top, bottom: top + HITS, ..self.frame };
        let degree = self.data.resolution.per_degree() as f64;
        for bin in 0..360_usize {
            let colour = match (self.data.known[bin], self.data.hit[bin]) {
                (false, _) => UNKNOWN,
                (true, hit) => super::style::hit_colour(hit),
            };
            // Bin j covers half a degree to either side of azimuth j.
            let start = ((540 - bin) % 360) as f64 * degree - degree / 2.0;
            for [left, right] in self.span([start, start + degree]) {
                canvas.fill(Rect { left, right, ..bar }, colour)?;
            }
        }
        canvas.text([self.frame.left - BESIDE, bar.centre()[1]], TICK_PX, LEFT, "hits")?;
        canvas.outline(bar, Pen::solid(INK, 2.0))
    }
}
