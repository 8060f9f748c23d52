//! Ranges and rules of the tables `[statics.adaptive]` and `[statics.arc-length]`.

use super::{Check, finite, named, positive_or_absent, require, within};
use crate::scene::{Scene, Statics};

/// Iterations that a step may be asked to take.
const ITERATIONS: std::ops::RangeInclusive<usize> = 2..=100;

pub(super) fn stepping(statics: &Statics, scene: &Scene) -> Check {
    let chosen = statics.adaptive.is_some() || statics.arc_length.is_some();
    require("statics.steps", !chosen || statics.steps > 0, "must be > 0, for the first step")?;
    if let Some(table) = &statics.adaptive {
        within("statics.adaptive.iterations", table.iterations, ITERATIONS)?;
        positive_or_absent("statics.adaptive.shortest", table.shortest, "t")?;
        positive_or_absent("statics.adaptive.longest", table.longest, "t")?;
        let first = scene.end() / statics.steps.max(1) as f64;
        let shortest = table.shortest.is_none_or(|shortest| shortest <= first);
        require("statics.adaptive.shortest", shortest, format!("is longer than the first step, {first}"))?;
        let longest = table.longest.is_none_or(|longest| longest >= first * (1.0 - 1e-9));
        require("statics.adaptive.longest", longest, format!("is shorter than the first step, {first}"))?;
    }
    let stepped = statics.steps > 0 || (statics.adaptive.is_none() && statics.arc_length.is_none());
    require("statics.steps", stepped, "must be > 0 for [statics.adaptive] and [statics.arc-length], which start from them")?;
    let Some(table) = &statics.arc_length else { return Ok(()) };
    let key = "statics.arc-length";
    require(key, statics.end.is_none(), "needs a load factor, which [statics] with `end` has not")?;
    require(key, statics.adaptive.is_none(), "chooses its own steps; [statics.adaptive] has no place beside it")?;
    require(key, !statics.stable, "follows unstable states too, which `stable` leaves")?;
    require(
        "output.interval",
        scene.output.interval.is_none(),
        "needs a time that only grows, which a path by [statics.arc-length] has not",
    )?;
    within(&format!("{key}.iterations"), table.iterations, ITERATIONS)?;
    require(&format!("{key}.longest"), table.longest >= 1.0 && table.longest.is_finite(), "must be >= 1")?;
    within(&format!("{key}.most_steps"), table.most_steps, 1..=100_000)?;
    let Some(until) = &table.until else { return Ok(()) };
    let key = format!("{key}.until");
    finite(&format!("{key}.at"), &until.at, "m")?;
    until.region.as_ref().map_or(Ok(()), |name| named(&format!("{key}.region"), name))?;
    let displacement = until.displacement;
    require(&format!("{key}.displacement"), displacement.is_finite() && displacement != 0.0, "must be finite and not 0 [m]")
}
