//! Rules of `[modes]`, and of what measures ask of it and of the reactions.

use super::*;

/// Modes that one scene may ask for.
const COUNT: RangeInclusive<usize> = 1..=200;

pub(super) fn modes(scene: &Scene) -> Check {
    let Some(table) = &scene.modes else { return Ok(()) };
    require("modes", scene.statics.is_some(), "needs [statics], whose last equilibrium the modes are about")?;
    within("modes.count", table.count, COUNT)?;
    let buckling = table.kind == ModeKind::Buckling;
    match table.shift {
        Some(shift) if buckling => require("modes.shift", shift >= 0.0 && shift.is_finite(), "must be >= 0 [1]")?,
        shift => positive_or_absent("modes.shift", shift, "1/s2")?,
    }
    let stepped = !buckling || scene.statics.as_ref().is_some_and(|table| table.steps > 0);
    require("statics.steps", stepped, "must be > 0 for modes of buckling, which need a load")
}

/// `measure` under `key` asks for the mode of this number.
pub(super) fn mode(key: &str, number: usize, kind: ModeKind, scene: &Scene) -> Check {
    let name = if kind == ModeKind::Vibration { "vibration" } else { "buckling" };
    let Some(table) = scene.modes.as_ref().filter(|table| table.kind == kind) else {
        return Err(fault(key, format!("needs [modes] with `kind = \"{name}\"`")));
    };
    within(&format!("{key}.mode"), number, 1..=table.count)
}

/// `measure` under `key` asks for reactions.
pub(super) fn reaction(key: &str, region: &str, about: Option<&[f64; 3]>, scene: &Scene) -> Check {
    require(key, scene.output.reactions, "needs `reactions = true` in [output]")?;
    named(&format!("{key}.region"), region)?;
    let Some(about) = about else { return Ok(()) };
    finite(&format!("{key}.about"), about, "m")?;
    let angles = scene.shell.director != Director::Average;
    require(key, angles, "needs directors of the edges' own, which `average` has not")
}
