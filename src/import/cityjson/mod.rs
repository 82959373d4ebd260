use super::collector::Collector;
use super::source::Source;
use super::{ImportError, Options};

pub(super) fn read(
    source: &Source,
    options: &Options,
    collector: &mut Collector,
    report: &dyn Fn(u64),
) -> Result<(), ImportError> {
    let _ = (source, options, collector, report);
    Ok(())
}
