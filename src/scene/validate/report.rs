//! Rules of `[report]`: expectations, measures, ladders, sweeps, matrices. Which regions, vertices and fields there are is not known here.

use super::*;

/// Values that a key of a sweep may have, and runs that a sweep may make.
const COUNT: RangeInclusive<usize> = 2..=1000;
const MOST_RUNS: usize = 10_000;

pub(super) fn report(report: &Report, scene: &Scene) -> Check {
    let end = scene.end();
    for (i, table) in report.expectations.iter().enumerate() {
        let key = |name: &str| format!("report.expect.{i}.{name}");
        named(&key("name"), &table.name)?;
        let new = report.expectations[..i].iter().all(|other| other.name != table.name);
        require(&key("name"), new, "an expectation of this name comes before")?;
        measure(&key("measure"), &table.measure, scene)?;
        finite(&key("reference"), &[table.reference], "unit of the measure")?;
        tolerance(&key("tolerance"), table.tolerance, "unit of the measure")?;
        named(&key("source"), &table.source)?;
        require(&key("time"), table.time.is_none_or(|time| time >= 0.0 && time.is_finite()), "must be >= 0 [s]")?;
        let within = table.time.is_none_or(|time| time <= end * (1.0 + 1e-9));
        require(&key("time"), within, format!("is after the end of the run at {end} (seconds, in statics the load factor)"))?;
        let ambiguous = table.time.is_some() && has_path(scene);
        require(&key("time"), !ambiguous, "may come more than once on a path by [statics.arc-length]; use `passage` or `limit-point`")?;
        spot(&format!("report.expect.{i}"), table.limit_point, table.passage.as_ref(), scene)?;
        let places = [table.time.is_some(), table.limit_point.is_some(), table.passage.is_some()];
        let places = places.into_iter().filter(|given| *given).count();
        require(&format!("report.expect.{i}"), places <= 1, "at most one of `time`, `limit-point` and `passage` may be given")?;
    }
    if let Some(path) = &report.path {
        require("report.path.measures", !path.measures.is_empty(), "must not be empty")?;
        for (i, entry) in path.measures.iter().enumerate() {
            let key = format!("report.path.measures.{i}");
            named(&format!("{key}.name"), &entry.name)?;
            let new = path.measures[..i].iter().all(|other| other.name != entry.name);
            let new = new && !["step", "t"].contains(&entry.name.as_str());
            require(&format!("{key}.name"), new, "a column of this name comes before")?;
            measure(&format!("{key}.measure"), &entry.measure, scene)?;
        }
    }
    if let Some(table) = &report.ladder {
        ladder(table, scene)?;
    }
    for (i, table) in report.sweeps.iter().enumerate() {
        let key = format!("report.sweep.{i}");
        let new = report.sweeps[..i].iter().all(|other| other.name != table.name);
        require(&format!("{key}.name"), new, "a sweep of this name comes before")?;
        sweep(&key, table, scene)?;
    }
    report.matrix.as_ref().map_or(Ok(()), |table| matrix::matrix(table, scene))
}

/// Whether the load factor is an unknown, and so may turn back.
fn has_path(scene: &Scene) -> bool {
    scene.statics.as_ref().is_some_and(|statics| statics.arc_length.is_some())
}

/// Places on a path.
fn spot(key: &str, limit_point: Option<usize>, passage: Option<&Passage>, scene: &Scene) -> Check {
    if let Some(number) = limit_point {
        let key = format!("{key}.limit-point");
        require(&key, has_path(scene), "needs [statics.arc-length]")?;
        require(&key, number > 0, "must be 1 or more")?;
    }
    let Some(passage) = passage else { return Ok(()) };
    measure(&format!("{key}.passage.measure"), &passage.measure, scene)?;
    finite(&format!("{key}.passage.value"), &[passage.value], "unit of the measure")?;
    require(&format!("{key}.passage.number"), passage.number > 0, "must be 1 or more")
}

fn tolerance(key: &str, value: f64, unit: &str) -> Check {
    require(key, value >= 0.0 && value.is_finite(), format!("must be >= 0 [{unit}]"))
}

fn measure(key: &str, measure: &Measure, scene: &Scene) -> Check {
    let region = |key: String, name: &Option<String>| name.as_ref().map_or(Ok(()), |name| named(&key, name));
    match measure {
        Measure::Displacement { at, .. } => finite(&format!("{key}.displacement.at"), at, "m"),
        Measure::DistanceBetween { a, b } => {
            finite(&format!("{key}.distance-between.a"), a, "m")?;
            finite(&format!("{key}.distance-between.b"), b, "m")
        }
        Measure::CylinderDistance { radius } => positive(&format!("{key}.cylinder-distance.radius"), *radius, "m"),
        Measure::SurfaceDistance { position, over, .. } => {
            expressions(&format!("{key}.surface-distance.position"), position, PLACE)?;
            positive_or_absent(&format!("{key}.surface-distance.over"), *over, "m")
        }
        Measure::OriginalDistance { over, .. } => positive_or_absent(&format!("{key}.original-distance.over"), *over, "m"),
        Measure::Asymmetry { at, over, .. } => {
            finite(&format!("{key}.asymmetry.at"), &[*at], "m")?;
            positive_or_absent(&format!("{key}.asymmetry.over"), *over, "m")
        }
        Measure::Waves { region } => named(&format!("{key}.waves.region"), region),
        Measure::WaveAmplitude { region } => named(&format!("{key}.wave-amplitude.region"), region),
        Measure::Energy { over, .. } => {
            let key = format!("{key}.energy.over");
            optional_expression(&key, over, SHELL)?;
            let constant = over.as_ref().and_then(|over| over.parse(SHELL).ok()).filter(|over| over.is_constant());
            constant.map_or(Ok(()), |over| positive(&key, over.eval(&[]), "J"))
        }
        Measure::Field { name, component, minus, region: of, .. } => {
            optional_expression(&format!("{key}.field.minus"), minus, PLACE_AND_TIME)?;
            named(&format!("{key}.field.name"), name)?;
            region(format!("{key}.field.region"), of)?;
            within(&format!("{key}.field.component"), *component, 0..=8)
        }
        Measure::Reaction { region, .. } => modes::reaction(&format!("{key}.reaction"), region, None, scene),
        Measure::ReactionMoment { region, about, .. } => modes::reaction(&format!("{key}.reaction-moment"), region, Some(about), scene),
        Measure::Frequency { mode } => modes::mode(&format!("{key}.frequency"), *mode, ModeKind::Vibration, scene),
        Measure::BucklingFactor { mode } => modes::mode(&format!("{key}.buckling-factor"), *mode, ModeKind::Buckling, scene),
        Measure::TimeWithin { column, least, most } => {
            named(&format!("{key}.time-within.column"), column)?;
            finite(&format!("{key}.time-within.least"), &[*least], "unit of the column")?;
            finite(&format!("{key}.time-within.most"), &[*most], "unit of the column")?;
            require(&format!("{key}.time-within.most"), least <= most, "must not be less than `least`")
        }
        Measure::History { column } => named(&format!("{key}.history.column"), column),
        Measure::CurvatureSquare { .. }
        | Measure::EnergyRatio { .. }
        | Measure::LoadFactor
        | Measure::TimeReached
        | Measure::NewtonIterations
        | Measure::Factorizations => Ok(()),
    }
}

fn ladder(ladder: &Ladder, scene: &Scene) -> Check {
    measure("report.ladder.measure", &ladder.measure, scene)?;
    spot("report.ladder", ladder.limit_point, None, scene)?;
    finite("report.ladder.reference", &[ladder.reference], "unit of the measure")?;
    let key = "report.ladder.resolutions";
    require(key, !ladder.resolutions.is_empty(), "must not be empty")?;
    resolutions(key, &ladder.resolutions, None, ladder, scene)?;
    if matches!(scene.mesh, MeshTable::File(_)) && ladder.refinement != Refinement::Steps {
        require(&format!("{key}.0"), ladder.resolutions[0] == 1.0, "must be 1, since the mesh is a file's")?;
        let splits = ladder.refinement == Refinement::Split || ladder.resolutions.len() == 1;
        require("report.ladder.refinement", splits, "must be \"split\", since the mesh is a file's")?;
    }
    for (i, table) in ladder.meshes.iter().enumerate() {
        let key = format!("report.ladder.meshes.{i}");
        require(&key, matches!(scene.mesh, MeshTable::Rectangle(_)), "variants exist for [mesh.rectangle] only")?;
        named(&format!("{key}.name"), &table.name)?;
        let new = ladder.meshes[..i].iter().all(|other| other.name != table.name);
        require(&format!("{key}.name"), new, "a mesh of this name comes before")?;
        jitter(&format!("{key}.jitter"), table.jitter, table.pattern)?;
    }
    ladder.thicknesses.iter().enumerate().try_for_each(|(i, &value)| positive(&format!("report.ladder.thicknesses.{i}"), value, "m"))?;
    let lawless = |rest: &Rest| *rest == Rest { sampling: rest.sampling, ramp: rest.ramp.clone(), ..Rest::default() };
    let law = scene.rest.as_ref().is_some_and(|rest| !lawless(rest));
    require("report.ladder.samplings", ladder.samplings.is_empty() || law, "needs a law in [rest] that could be sampled")?;
    for (i, value) in ladder.samplings.iter().enumerate() {
        require(&format!("report.ladder.samplings.{i}"), !ladder.samplings[..i].contains(value), "comes twice")?;
    }
    ways(ladder, scene)?;
    for (i, table) in ladder.expectations.iter().enumerate() {
        ladder_expectation(&format!("report.ladder.expect.{i}"), table, ladder, scene)?;
    }
    Ok(())
}

/// Steps, integrators and methods of a ladder.
fn ways(ladder: &Ladder, scene: &Scene) -> Check {
    let steps = ladder.refinement == Refinement::Steps;
    require("report.ladder.refinement", !steps || scene.dynamics.is_some(), "`steps` needs [dynamics], whose `dt` it divides")?;
    if let Some(dynamics) = scene.dynamics.as_ref().filter(|_| steps) {
        require("report.ladder.refinement", dynamics.adaptive.is_none(), "`steps` needs steps of one size, without `dynamics.adaptive`")?;
    }
    let key = "report.ladder.integrators";
    require(key, ladder.integrators.is_empty() || scene.dynamics.is_some(), "needs [dynamics]")?;
    for (i, value) in ladder.integrators.iter().enumerate() {
        require(&format!("{key}.{i}"), !ladder.integrators[..i].contains(value), "comes twice")?;
    }
    let key = "report.ladder.methods";
    require(key, ladder.methods.is_empty() || scene.statics.is_some(), "needs [statics]")?;
    for (i, value) in ladder.methods.iter().enumerate() {
        require(&format!("{key}.{i}"), !ladder.methods[..i].contains(value), "comes twice")?;
        let plain = scene.statics.as_ref().is_some_and(|s| !s.stable && s.arc_length.is_none() && s.adaptive.is_none());
        let goes = *value == Method::Newton || plain;
        require(&format!("{key}.{i}"), goes, "goes without `stable`, [statics.arc-length] and [statics.adaptive]")?;
    }
    Ok(())
}

/// Factors that ascend, the first from the one `before`, and that splitting comes to, or that make no more steps than a run may have.
fn resolutions(key: &str, factors: &[f64], before: Option<f64>, ladder: &Ladder, scene: &Scene) -> Check {
    let dynamics = scene.dynamics.as_ref().filter(|_| ladder.refinement == Refinement::Steps);
    for (i, &factor) in factors.iter().enumerate() {
        let key = format!("{key}.{i}");
        positive(&key, factor, "1")?;
        let before = i.checked_sub(1).map(|i| factors[i]).or(before);
        require(&key, before.is_none_or(|before| before < factor), "must be larger than the one before")?;
        let doublings = (factor / ladder.resolutions[0]).log2();
        let splits = ladder.refinement != Refinement::Split || (doublings - doublings.round()).abs() < 1e-9;
        require(&key, splits, "must be the first times 2, 4, 8, ..., since meshes are split")?;
        let count = dynamics.map_or(0.0, |dynamics| scene.end() / dynamics.dt * factor);
        require(&key, count <= MOST_STEPS, format!("makes {count:e} steps to the end, must be at most {MOST_STEPS:e}"))?;
    }
    Ok(())
}

/// What is expected of is there, so that no expectation is met by being about nothing.
fn ladder_expectation(key: &str, table: &LadderExpectation, ladder: &Ladder, scene: &Scene) -> Check {
    fn among<T: PartialEq + Copy>(key: String, value: Option<T>, list: &[T], own: T) -> Check {
        let there = value.is_none_or(|value| if list.is_empty() { value == own } else { list.contains(&value) });
        require(&key, there, "is not among those of the ladder")
    }
    among(format!("{key}.element"), table.element, &ladder.elements, scene.shell.element)?;
    among(format!("{key}.director"), table.director, &ladder.directors, scene.shell.director)?;
    let elements = if ladder.elements.is_empty() { &[scene.shell.element][..] } else { &ladder.elements };
    let directors = if ladder.directors.is_empty() { &[scene.shell.director][..] } else { &ladder.directors };
    let linear = table.element.map_or(elements.contains(&Element::Linear), |element| element == Element::Linear);
    let free = table.director.map_or_else(|| directors.iter().any(|d| *d != Director::Average), |d| d != Director::Average);
    require(key, linear || free, "is about no run, since `average` exists for the linear element only")?;
    among(format!("{key}.thickness"), table.thickness, &ladder.thicknesses, scene.shell.thickness)?;
    let mesh = table.mesh.as_ref().is_none_or(|name| ladder.meshes.iter().any(|mesh| mesh.name == *name));
    require(&format!("{key}.mesh"), mesh, "is not among those of the ladder")?;
    require(&format!("{key}.sampling"), table.sampling.is_none_or(|s| ladder.samplings.contains(&s)), "is not among those of the ladder")?;
    let there = table.integrator.is_none_or(|i| ladder.integrators.contains(&i));
    require(&format!("{key}.integrator"), there, "is not among those of the ladder")?;
    require(&format!("{key}.method"), table.method.is_none_or(|m| ladder.methods.contains(&m)), "is not among those of the ladder")?;
    let some = table.least_order.is_some() || table.largest_error.is_some() || !table.meets.is_empty();
    require(key, some, "must give `least_order`, `largest_error` or `meets`")?;
    for (i, name) in table.meets.iter().enumerate() {
        let known = scene.report.iter().flat_map(|report| &report.expectations).any(|expected| expected.name == *name);
        require(&format!("{key}.meets.{i}"), known, "is the name of no [[report.expect]]")?;
    }
    finite(&format!("{key}.least_order"), table.least_order.as_slice(), "1")?;
    let further = format!("{key}.further");
    resolutions(&further, &table.further, ladder.resolutions.last().copied(), ladder, scene)?;
    let finer = !matches!(scene.mesh, MeshTable::File(_)) || ladder.refinement != Refinement::Anew || table.further.is_empty();
    require(&further, finer, "needs `refinement = \"split\"`, since the mesh is a file's")?;
    let pairs = table.least_order.is_none() || ladder.resolutions.len() + table.further.len() > 1;
    require(&format!("{key}.least_order"), pairs, "needs two resolutions to compare")?;
    if let Some(error) = table.largest_error {
        tolerance(&format!("{key}.largest_error"), error, "unit of the measure")?;
    }
    named(&format!("{key}.source"), &table.source)
}

fn sweep(key: &str, table: &Sweep, scene: &Scene) -> Check {
    named(&format!("{key}.name"), &table.name)?;
    let first = sweep_key(key, &table.key, &table.values, table.logarithmic.as_ref())?;
    let mut runs = first.len();
    if let Some(second) = &table.second {
        let key = format!("{key}.second");
        let values = sweep_key(&key, &second.key, &second.values, second.logarithmic.as_ref())?;
        require(&format!("{key}.key"), second.key != table.key, "is the first key too")?;
        runs = runs.saturating_mul(values.len());
    }
    require(key, runs <= MOST_RUNS, format!("makes {runs} runs, must be at most {MOST_RUNS}"))?;
    require(&format!("{key}.measures"), !table.measures.is_empty(), "must not be empty")?;
    sweep_measures(&format!("{key}.measures"), &table.measures, scene)?;
    let known = |name: &str| table.measures.iter().any(|measure| measure.name == name);
    if let Some(shapes) = &table.shapes {
        let passes = shapes.time.is_none_or(|time| time >= 0.0 && time.is_finite());
        require(&format!("{key}.shapes.time"), passes, "must be >= 0 [s]")?;
        require(&format!("{key}.shapes"), first.len() > 1, "needs two values of the key or more")?;
    }
    if let Some(largest) = &table.largest {
        let key = format!("{key}.largest");
        require(&format!("{key}.measure"), known(&largest.measure), "is the name of no measure of the sweep")?;
        finite(&format!("{key}.least"), &[largest.least], "unit of the measure")?;
        let second = table.second.as_ref().map_or(Vec::new(), SecondKey::list);
        let numbers = !second.is_empty() && second.iter().all(|value| value.number().is_some());
        require(&key, numbers, "needs a second key whose values are numbers")?;
    }
    table.fit.as_ref().map_or(Ok(()), |law| fit(&format!("{key}.fit"), law, table, &first))?;
    for (i, tied) in table.with.iter().enumerate() {
        matrix::values(&format!("{key}.with.{i}"), &tied.key, &tied.values, first.len())?;
    }
    matrix::changes(&format!("{key}.set"), &table.set)
}

/// Measures with limits; `key` is that of their list.
pub(super) fn sweep_measures(key: &str, measures: &[SweepMeasure], scene: &Scene) -> Check {
    for (i, entry) in measures.iter().enumerate() {
        let key = format!("{key}.{i}");
        named(&format!("{key}.name"), &entry.name)?;
        let new = measures[..i].iter().all(|other| other.name != entry.name);
        require(&format!("{key}.name"), new, "a measure of this name comes before")?;
        measure(&format!("{key}.measure"), &entry.measure, scene)?;
        spot(&key, entry.limit_point, entry.passage.as_ref(), scene)?;
        let places = usize::from(entry.time.is_some()) + usize::from(entry.limit_point.is_some()) + usize::from(entry.passage.is_some());
        require(&key, places <= 1, "at most one of `time`, `limit-point` and `passage` may be given")?;
        // Whether a run lasts so long depends on its values.
        let passes = entry.time.is_none_or(|time| time >= 0.0 && time.is_finite());
        require(&format!("{key}.time"), passes, "must be >= 0 [s]")?;
        finite(&format!("{key}.least"), entry.least.as_slice(), "unit of the measure")?;
        finite(&format!("{key}.most"), entry.most.as_slice(), "unit of the measure")?;
        let ordered = entry.least.zip(entry.most).is_none_or(|(least, most)| least <= most);
        require(&format!("{key}.most"), ordered, "must not be less than `least`")?;
        let limited = entry.least.is_some() || entry.most.is_some();
        require(&key, limited == entry.source.is_some(), "`source` and a limit, `least` or `most`, need each other")?;
        entry.source.as_ref().map_or(Ok(()), |source| named(&format!("{key}.source"), source))?;
    }
    Ok(())
}

/// The values of a key.
fn sweep_key(at: &str, key: &str, values: &[SweepValue], logarithmic: Option<&Logarithmic>) -> Result<Vec<SweepValue>, Fault> {
    let parts = key.split('.').all(|part| !part.trim().is_empty()) && !key.contains('=');
    require(&format!("{at}.key"), parts, "must be names joined by dots")?;
    require(at, values.is_empty() == logarithmic.is_some(), "exactly one of `values` and `logarithmic` must be given")?;
    if let Some(table) = logarithmic {
        let at = format!("{at}.logarithmic");
        positive(&format!("{at}.from"), table.from, "unit of the key")?;
        positive(&format!("{at}.to"), table.to, "unit of the key")?;
        require(&format!("{at}.to"), table.from != table.to, "is the same as `from`")?;
        within(&format!("{at}.count"), table.count, COUNT)?;
        return Ok(table.values());
    }
    require(&format!("{at}.values"), values.len() <= *COUNT.end(), format!("must be at most {}", COUNT.end()))?;
    for (i, value) in values.iter().enumerate() {
        let at = format!("{at}.values.{i}");
        require(&at, value.number().is_none_or(f64::is_finite), "must be finite")?;
        require(&at, values[..i].iter().all(|other| other.text() != value.text()), "comes twice")?;
    }
    Ok(values.to_vec())
}

fn fit(key: &str, law: &Fit, table: &Sweep, values: &[SweepValue]) -> Check {
    let known = table.measures.iter().any(|measure| measure.name == law.measure);
    require(&format!("{key}.measure"), known, "is the name of no measure of the sweep")?;
    if let Some(lowest) = &law.lowest {
        let known = table.measures.iter().any(|measure| measure.name == *lowest);
        require(&format!("{key}.lowest"), known, "is the name of no measure of the sweep")?;
        require(&format!("{key}.lowest"), table.second.is_some(), "needs a second key, among whose runs it chooses")?;
    }
    let numbers = values.len() > 1 && values.iter().all(|value| value.number().is_some_and(|number| number > 0.0));
    require(key, numbers, "needs two values of the key or more, numbers > 0 all of them")?;
    let Some(expected) = &law.expect else { return Ok(()) };
    finite(&format!("{key}.expect.exponent"), &[expected.exponent], "1")?;
    tolerance(&format!("{key}.expect.tolerance"), expected.tolerance, "1")?;
    named(&format!("{key}.expect.source"), &expected.source)
}
