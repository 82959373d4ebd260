//! What is said on standard error.

/// Says a line. Where nobody listens any more, it is lost and the work goes on.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

pub(super) use say;
