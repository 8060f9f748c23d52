//! Ranges and rules of the tables `[moisture]` and `[heat]`.

use super::{Check, expression, finite, named, optional_expression, positive, positive_or_absent, require, within};
use crate::scene::{BODY, BODY_AND_TIME, Boundary, DIFFUSED, Diffusion, Diffusivity, PLACE_AND_TIME, Rest, Scene};

/// Layers through the thickness.
const LAYERS: std::ops::RangeInclusive<usize> = 1..=1000;

/// Rules of both tables, and of what goes with them.
pub(in crate::scene) fn diffusing(scene: &Scene) -> Check {
    let heavier = scene.heat.as_ref().is_some_and(|heat| heat.added_density.is_some());
    require("heat.added_density", !heavier, "exists for [moisture] only")?;
    for (table, _, _, diffusion) in scene.diffusing() {
        require(table, scene.runs_in_time(), "needs time: [dynamics], or `end` in [statics]")?;
        self::diffusion(table, diffusion, scene)?;
        let reads = |rest: &&Rest| if table == "heat" { rest.thermal.is_some() } else { rest.linear.is_some() || rest.bilayer.is_some() };
        let ramped = scene.rest.as_ref().filter(reads).is_some_and(|rest| rest.ramp.is_some());
        require("rest.ramp", !ramped, format!("cannot be combined with a law that [{table}] drives, which brings its own course in time"))?;
    }
    Ok(())
}

fn diffusion(table: &str, diffusion: &Diffusion, scene: &Scene) -> Check {
    let at = |key: &str| format!("{table}.{key}");
    within(&at("layers"), diffusion.layers.unwrap_or(1), LAYERS)?;
    for (key, there) in [("layers", diffusion.layers.is_some()), ("spacing", diffusion.spacing.is_some())] {
        require(&at(key), !there || diffusion.levels.is_none(), "cannot be combined with `levels`")?;
    }
    if let Some(levels) = &diffusion.levels {
        let ascending = levels.windows(2).all(|pair| pair[0] < pair[1]);
        let whole = levels.first() == Some(&0.0) && levels.last() == Some(&1.0) && levels.len() <= LAYERS.end() + 1;
        require(&at("levels"), ascending && whole, "must ascend from 0 to 1, at most 1001 heights")?;
    }
    let fibres = scene.machine_direction.is_some();
    diffusivity(&at("diffusivity"), &diffusion.diffusivity, fibres)?;
    for (i, region) in diffusion.regions.iter().enumerate() {
        named(&at(&format!("region.{i}.region")), &region.region)?;
        diffusivity(&at(&format!("region.{i}.diffusivity")), &region.diffusivity, fibres)?;
    }
    positive_or_absent(&at("dt"), diffusion.dt, "s")?;
    super::rest::scalar(&at("initial"), &diffusion.initial, BODY)?;
    optional_expression(&at("source"), &diffusion.source, BODY_AND_TIME)?;
    optional_expression(&at("stiffness"), &diffusion.stiffness, DIFFUSED)?;
    if let Some(density) = diffusion.added_density {
        positive(&at("added_density"), density, "kg/m3")?;
        require(&at("added_density"), scene.shell.density.is_some(), "needs `density` in [shell]")?;
    }
    diffusion.boundaries.iter().enumerate().try_for_each(|(i, boundary)| self::boundary(&at(&format!("boundary.{i}")), boundary))
}

fn diffusivity(key: &str, table: &Diffusivity, fibres: bool) -> Check {
    for (name, value) in [("through", Some(table.through)), ("along", Some(table.along)), ("across", table.across)] {
        let valid = value.is_none_or(|value| value >= 0.0 && value.is_finite());
        require(&format!("{key}.{name}"), valid, "must be >= 0 [m2/s]")?;
    }
    require(&format!("{key}.across"), table.across.is_none() || fibres, "needs the table [machine-direction]")
}

fn boundary(key: &str, table: &Boundary) -> Check {
    let given = [table.value.is_some(), table.flux.is_some(), table.exchange.is_some()];
    require(key, given.iter().filter(|given| **given).count() == 1, "exactly one of `value`, `flux` and `exchange` must be given")?;
    table.region.as_ref().map_or(Ok(()), |name| named(&format!("{key}.region"), name))?;
    optional_expression(&format!("{key}.value"), &table.value, PLACE_AND_TIME)?;
    optional_expression(&format!("{key}.flux"), &table.flux, PLACE_AND_TIME)?;
    if let Some(exchange) = &table.exchange {
        positive(&format!("{key}.exchange.coefficient"), exchange.coefficient, "m/s")?;
        expression(&format!("{key}.exchange.outside"), &exchange.outside, PLACE_AND_TIME)?;
    }
    finite(&format!("{key}.from"), table.from.as_slice(), "s")?;
    finite(&format!("{key}.until"), table.until.as_slice(), "s")?;
    finite(&format!("{key}.below"), table.below.as_slice(), "m")?;
    let ends = table.until.is_none_or(|until| until > table.from.unwrap_or(0.0).max(0.0));
    require(&format!("{key}.until"), ends, "must come after `from` and after the start")
}
