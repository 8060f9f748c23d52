//! Rules of the loads that are spread over faces: `[[surface-load]]`, `[[body-force]]`, `[[wind]]`.

use super::*;

pub(super) fn distributed(scene: &Scene) -> Check {
    let tables = [("surface-load", &scene.surface_loads), ("body-force", &scene.body_forces)];
    for (table, (i, load)) in tables.iter().flat_map(|(table, loads)| loads.iter().enumerate().map(move |pair| (*table, pair))) {
        let key = |name: &str| format!("{table}.{i}.{name}");
        load.region.as_ref().map_or(Ok(()), |name| named(&key("region"), name))?;
        expressions(&key("force"), &load.force, PLACE_AND_TIME)?;
        optional_expression(&key("factor"), &load.factor, TIME)?;
    }
    for (i, wind) in scene.winds.iter().enumerate() {
        let key = |name: &str| format!("wind.{i}.{name}");
        require(&format!("wind.{i}"), scene.dynamics.is_some(), "needs [dynamics]; in statics use [[pressure]] or [[surface-load]]")?;
        wind.region.as_ref().map_or(Ok(()), |name| named(&key("region"), name))?;
        expressions(&key("velocity"), &wind.velocity, PLACE_AND_TIME)?;
        positive(&key("density"), wind.density, "kg/m3")?;
        for (name, value) in [("normal", wind.normal), ("tangential", wind.tangential)] {
            require(&key(name), value >= 0.0 && value.is_finite(), "must be >= 0 [1]")?;
        }
        require(&format!("wind.{i}"), wind.normal > 0.0 || wind.tangential > 0.0, "has no effect: both coefficients are 0")?;
    }
    Ok(())
}
