//! Drawings of any bytes.
#![no_main]

use compass_fuzz::file;
use compass_host::plan_import::{PlanOptions, import};
use libfuzzer_sys::fuzz_target;
use std::sync::Once;

fuzz_target!(|data: &[u8]| {
    // Readers of CAD and PDF may panic: the import catches that, and the hook that would abort is taken away.
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let Some((kind, data)) = data.split_first() else { return };
    let name = ["plan.svg", "plan.pdf", "plan.dxf", "plan.dwg"][usize::from(kind % 4)];
    let mut options = PlanOptions::new(file(name, data));
    options.resolution_m = Some(0.1);
    options.drawing.scale = (kind % 4 < 2).then_some(100.0);
    let _ = import(&options);
});
