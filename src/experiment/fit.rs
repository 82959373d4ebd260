//! Least squares for the models the experiments compare with.

/// count = c·(D + s)².
#[derive(Debug, Clone, Copy)]
pub(super) struct DiscModel {
    pub scale: f64,
    /// s, m.
    pub node_size: f64,
    pub r2: f64,
}

/// Fits c·(D + s)²: √count is linear in D, with slope √c and intercept √c·s.
///
/// R² is that of the counts, not of their roots.
pub(super) fn disc_model(points: &[(f64, f64)]) -> DiscModel {
    let roots: Vec<(f64, f64)> = points.iter().map(|&(d, n)| (d, n.sqrt())).collect();
    let (slope, intercept) = line(&roots);
    let model = |d: f64| (slope * d + intercept).powi(2);
    DiscModel {
        scale: slope * slope,
        node_size: intercept / slope,
        r2: r2(points, model),
    }
}

/// p of count ∝ D^p.
pub(super) fn exponent(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(d, n)| (d.ln(), n.ln())).collect();
    line(&logs).0
}

/// Slope and intercept.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / n;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / n;
    let xy: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    let xx: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    let slope = xy / xx;
    (slope, mean_y - slope * mean_x)
}

fn r2(points: &[(f64, f64)], model: impl Fn(f64) -> f64) -> f64 {
    let mean = points.iter().map(|p| p.1).sum::<f64>() / points.len() as f64;
    let left: f64 = points.iter().map(|p| (p.1 - model(p.0)).powi(2)).sum();
    let all: f64 = points.iter().map(|p| (p.1 - mean).powi(2)).sum();
    1.0 - left / all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_model_that_made_the_points() {
        let points: Vec<(f64, f64)> = [200.0, 300.0, 450.0, 675.0]
            .into_iter()
            .map(|d: f64| (d, 0.25 * (d + 40.0).powi(2)))
            .collect();
        let model = disc_model(&points);
        assert!((model.scale - 0.25).abs() < 1e-9);
        assert!((model.node_size - 40.0).abs() < 1e-6);
        assert!((model.r2 - 1.0).abs() < 1e-9);
        let squares: Vec<(f64, f64)> = points.iter().map(|&(d, _)| (d, d * d)).collect();
        assert!((exponent(&squares) - 2.0).abs() < 1e-9);
    }
}
