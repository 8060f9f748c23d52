//! One wrong scene per rule, given to the real program: exit code 2, one message at the right place, nothing written.

use std::path::Path;
use std::process::{Command, Output};

const FULL: &str = include_str!("full.toml");

/// Part of the full scene, what is put in its place with `§` before the expected place of the message, and the message.
const WRONG: &[(&str, &str, &str)] = &[
    // Syntax.
    ("dt = 0.1", "dt = §", "not valid TOML"),
    ("dt = 0.1", "dt = 0.1\n§dt = 0.2", "duplicate key"),
    ("[shell]\n", "[shell§\n", "not valid TOML"),
    // Keys.
    ("thickness = 1e-3 #", "§thicknes = 1e-3 #", "shell.thicknes: unknown key\n  help: did you mean `thickness`?"),
    ("[dynamics]", "[§dynamic]", "dynamic: unknown key\n  help: did you mean `dynamics`?"),
    ("size = [1.0", "§sise = [1.0", "mesh.rectangle.sise: unknown key\n  help: did you mean `size`?"),
    ("axis = \"z\"", "§axs = \"z\"", "report.expect.0.measure.displacement.axs: unknown key\n  help: did you mean `axis`?"),
    ("name = \"regular\"", "§nam = \"regular\"", "report.ladder.meshes.0.nam: unknown key\n  help: did you mean `name`?"),
    ("[shell]\nthickness = 1e-3", "§[shell]\n", "shell.thickness: this key is missing"),
    ("[mesh.rectangle]\nsize = [1.0, 0.2]", "§[mesh.rectangle]", "mesh.rectangle.size: this key is missing"),
    ("measure = { displacement = { at = [1.0, 0.1, 0.0], ", "measure = { displacement = §{ ", "displacement.at: this key is missing"),
    // Types and choices.
    ("thickness = 1e-3 #", "thickness = §\"thin\" #", "shell.thickness = \"thin\": expected a number, found string \"thin\""),
    ("cells = [20, 4]", "cells = [20, §-4]", "mesh.rectangle.cells.1 = -4: expected a whole number >= 0"),
    ("cells = [20, 4]", "cells = §[20]", "mesh.rectangle.cells = [20]: invalid length 1"),
    ("m_minus = 0", "m_minus = §[1]", "rest.linear.m_minus = [1]: expected a number or an expression in quotes, found an array"),
    ("[gravity]\nfactor = \"t\"", "§[[gravity]]", "gravity: expected a table in single brackets"),
    ("[mesh.rectangle]", "§[mesh.rectangel]", "mesh.rectangel: `rectangel` is not a choice here\n  help: did you mean `rectangle`?"),
    ("[mesh.rectangle]", "§[mesh]\ndisc = { radius = 1, rings = 3 }\n[mesh.rectangle]", "mesh: exactly one kind"),
    ("[output]", "§[shell.mass]\n[output]", "shell.mass"),
    ("director = \"clamped\"", "director = §\"clampt\"", "pin.0.director = \"clampt\": `clampt` is not a choice here"),
    ("components = [\"x\", \"z\"]", "components = [\"x\", §\"w\"]", "pin.1.components.1 = \"w\": `w` is not a choice here"),
    // Mesh.
    ("size = [1.0, 0.2]", "size = [1.0, §0.0]", "mesh.rectangle.size.1 = 0.0: must be > 0 [m]"),
    ("size = [1.0, 0.2]", "size = [§inf, 0.2]", "mesh.rectangle.size.0 = inf: must be > 0 [m]"),
    ("cells = [20, 4]", "cells = [20, §10001]", "must be 1 to 10000"),
    ("jitter = 0.1", "jitter = §0.5", "mesh.rectangle.jitter = 0.5: must be 0 to 0.45"),
    ("jitter = 0.1", "jitter = §0.1\npattern = \"delaunay\"", "mesh.rectangle.jitter = 0.1: cannot be combined"),
    ("jitter = 0.1", "triangulation = §{ size = 0.1 }", "needs `pattern = \"delaunay\"`"),
    ("jitter = 0.1", "pattern = \"delaunay\"\ntriangulation = { size = §0 }", "mesh.rectangle.triangulation.size = 0: must be > 0"),
    ("jitter = 0.1", "pattern = \"delaunay\"\ntriangulation = { size = 1, min_angle = §31 }", "must be 0 to 30"),
    ("[refine]\ntimes = 1", "[refine]\ntimes = §0", "refine.times = 0: must be 1 to 12"),
    ("[refine]\ntimes = 1", "[refine]\ntimes = §13", "refine.times = 13: must be 1 to 12"),
    ("[refine]\ntimes = 1", "§[refine]", "refine.times: this key is missing"),
    // Regions.
    ("name = \"tip\"\nwhere", "name = §\"\"\nwhere", "region.0.name = \"\": must not be empty"),
    ("name = \"corner\"", "name = §\"tip\"", "region.1.name = \"tip\": a region of this name comes before"),
    ("[[region]]\nname = \"tip\"\nwhere = \"x > 0.99\"", "§[[region]]\nname = \"tip\"", "region.0: exactly one of `where` and `nearest`"),
    ("where = \"x > 0.99\"", "where = §\"x > t\"", "region.0.where = \"x > t\": unknown name `t`; variables here: x, y, z, r, theta"),
    ("where = \"x > 0.99\"", "where = §\"x > \"", "found the end"),
    ("nearest = [1.0, 0.2, 0.0]", "nearest = §[1.0, 0.2, nan]", "must be finite"),
    // Shell.
    ("thickness = 1e-3 #", "thickness = §-0.001 #", "shell.thickness = -0.001: must be > 0 [m]"),
    ("youngs_modulus = 1e9", "youngs_modulus = §nan", "shell.youngs_modulus = nan: must be > 0 [Pa]"),
    ("poissons_ratio = 0.3\n", "poissons_ratio = §0.5\n", "shell.poissons_ratio = 0.5: must be > -1 and < 0.5"),
    ("density = 1000.0", "density = §0", "shell.density = 0: must be > 0 [kg/m3]"),
    ("viscosity = 0.01", "viscosity = §0", "shell.viscosity = 0: must be > 0 [s]"),
    ("thickness = 2e-3", "thickness = §0.0", "shell.region.0.thickness = 0.0: must be > 0 [m]"),
    ("region = \"tip\"\nthickness", "region = §\" \"\nthickness", "shell.region.0.region = \" \": must not be empty"),
    // Rest shape.
    ("ramp = \"min(t, 1)\"", "ramp = §2", "rest.ramp = 2: must be 0 to 1"),
    ("ramp = \"min(t, 1)\"", "ramp = §\"x\"", "rest.ramp = \"x\": unknown name `x`; variables here: t"),
    (
        "[rest]\nramp = \"min(t, 1)\"",
        "§[rest]\nbilayer = { m_plus = 0, m_minus = 0, mu = [0, 0] }",
        "rest: at most one of these laws may be given: `linear`, `bilayer`",
    ),
    (
        "ramp = \"min(t, 1)\"",
        "pullback = {}\nsurface = { sphere = { radius = 1 } }",
        "rest: at most one of these laws may be given: `pullback`, `surface`",
    ),
    (
        "ramp = \"min(t, 1)\"",
        "surface = { torus = { radii = [§1, 1] } }",
        "rest.surface.torus.radii.0 = 1: must be larger than the radius of the tube",
    ),
    ("ramp = \"min(t, 1)\"", "isotropic = { s = { field = §\"\" } }", "rest.isotropic.s.field = \"\": must not be empty"),
    ("ramp = \"min(t, 1)\"", "isotropic = { s = { field = \"f\", times = §\"q\" } }", "rest.isotropic.s.times = \"q\": unknown name `q`"),
    (
        "ramp = \"min(t, 1)\"",
        "isotropic = { s = §[1] }",
        "rest.isotropic.s = [1]: expected a number, an expression in quotes or { field = \"name\" }",
    ),
    ("ramp = \"min(t, 1)\"", "orthotropic = { factors = [1, §\"q\"] }", "rest.orthotropic.factors.1 = \"q\": unknown name `q`"),
    ("ramp = \"min(t, 1)\"", "prestress = §{}", "rest.prestress = {}: must give `times`, `plus_a` or `plus_b`"),
    ("ramp = \"min(t, 1)\"", "shape = { file = { path = \"a.obj\", scale = §0 } }", "rest.shape.file.scale = 0: must be > 0"),
    ("m_plus = \"2 * t\"", "m_plus = §\"2 * q\"", "rest.linear.m_plus = \"2 * q\": unknown name `q`"),
    ("m_plus = \"2 * t\"", "m_plus = §\"sqrt(-1)\"", "rest.linear.m_plus = \"sqrt(-1)\": must be finite"),
    ("mu = 0.001", "mu = §inf", "rest.linear.mu = inf: must be finite"),
    ("[machine-direction]\nangle = \"30 + x\"", "", "rest.linear.mu_perp = 0.002: needs the table [machine-direction]"),
    ("angle = \"30 + x\"", "angle = §\"30 + t\"", "unknown name `t`"),
    ("angle = \"30 + x\"", "vector = §[0, 0, 0]", "machine-direction.vector = [0, 0, 0]: must not be the zero vector"),
    // Loads.
    ("force = [0, 0, \"-20 * x\"]", "force = [0, 0, §\"-20 * u\"]", "surface-load.0.force.2 = \"-20 * u\": unknown name `u`"),
    ("force = [\"5 * y\", 0, 0]", "force = [§nan, 0, 0]", "body-force.0.force.0 = nan: must be finite"),
    ("[dynamics]", "[[wind]]\ntangential = §-0.1\n[dynamics]", "wind.0.tangential = -0.1: must be >= 0 [1]"),
    ("[dynamics]", "[[wind]]\nregion = §\"\"\n[dynamics]", "wind.0.region = \"\": must not be empty"),
    ("[dynamics]", "§[modes]\nkind = \"vibration\"\n[dynamics]", "modes: needs [statics]"),
    ("factor = \"t\"", "acceleration = [0, 0, §inf]", "gravity.acceleration.2 = inf: must be finite"),
    ("factor = \"t\"", "factor = §\"x\"", "gravity.factor = \"x\": unknown name `x`; variables here: t"),
    ("region = \"left\"", "region = §\"\"", "pin.0.region = \"\": must not be empty"),
    ("region = \"left\"\ndirector = \"clamped\"", "region = \"left\"\ncomponents = §[]", "pin.0.components = []: holds nothing"),
    ("components = [\"x\", \"z\"]", "components = §[\"x\", \"x\"]", "pin.1.components = [\"x\", \"x\"]: a component is repeated"),
    ("symmetry = [1.0, 0.0, 0.0]", "symmetry = §[0, 0, 0]", "pin.1.director.symmetry = [0, 0, 0]: must not be the zero vector"),
    ("motion = { x = \"0.1 * t\" }", "motion = { y = §1 }", "pin.1.motion.y = 1: `y` is not among the held `components`"),
    ("motion = { x = \"0.1 * t\" }", "motion = §{ }", "pin.1.motion = {}: must give x, y or z"),
    ("motion = { x = \"0.1 * t\" }", "motion = { x = §\"0.1 * r\" }", "unknown name `r`; variables here: x, y, z, t"),
    // Time.
    (
        "[dynamics]\ndt = 0.1\nend = 1.0\nvelocity = [0, 0, \"x\"]\nintegrator = \"generalised-alpha\"\nspectral_radius = 0.9\nadaptive = { tolerance = 2e-3, largest_dt = 0.2 }\nrandom_velocity = { speed = 0.7, seed = 11 }",
        "",
        "exactly one of [statics] and [dynamics] must be given, found none",
    ),
    ("integrator = \"generalised-alpha\"", "integrator = §\"newmark\"", "`newmark` is not a choice here"),
    (
        "integrator = \"generalised-alpha\"\nspectral_radius = 0.9",
        "integrator = \"bdf2\"\nspectral_radius = §0.9",
        "needs `integrator = \"generalised-alpha\"`",
    ),
    ("spectral_radius = 0.9", "spectral_radius = §1.1", "dynamics.spectral_radius = 1.1: must be 0 to 1"),
    ("tolerance = 2e-3", "tolerance = §0.2", "dynamics.adaptive.tolerance = 0.2: must be 0.0000000001 to 0.1"),
    ("largest_dt = 0.2", "largest_dt = §0", "dynamics.adaptive.largest_dt = 0: must be > 0 [s]"),
    ("[dynamics]", "[statics]\n§[dynamics]", "dynamics: exactly one of [statics] and [dynamics] must be given, found both"),
    ("dt = 0.1", "dt = §0", "dynamics.dt = 0: must be > 0 [s]"),
    ("end = 1.0", "end = §-1", "dynamics.end = -1: must be > 0 [s]"),
    ("velocity = [0, 0, \"x\"]", "velocity = [0, 0, §\"t\"]", "dynamics.velocity.2 = \"t\": unknown name `t`"),
    ("tolerance = 1e-8", "tolerance = §0.1", "solver.tolerance = 0.1: must be"),
    ("tolerance = 1e-8", "max_iterations = §0", "solver.max_iterations = 0: must be 1 to 1000"),
    ("tolerance = 1e-8", "max_halvings = §41", "solver.max_halvings = 41: must be 0 to 40"),
    ("interval = 0.5", "interval = §0", "output.interval = 0: must be > 0 [s]"),
    // Report.
    ("tolerance = 0.01", "tolerance = §-0.01", "report.expect.0.tolerance = -0.01: must be >= 0"),
    ("reference = 0.1", "reference = §nan", "report.expect.0.reference = nan: must be finite"),
    ("time = 0.5", "time = §-1", "report.expect.0.time = -1: must be >= 0 [s]"),
    ("source = \"beam theory\"", "source = §\"\"", "report.expect.0.source = \"\": must not be empty"),
    ("at = [1.0, 0.1, 0.0]", "at = §[1.0, 0.1, inf]", "displacement.at = [1.0, 0.1, inf]: must be finite"),
    (
        "measure = { displacement = { at = [1.0, 0.1, 0.0], axis = \"z\" } }",
        "measure = { cylinder-distance = { radius = §0 } }",
        "must be > 0 [m]",
    ),
    (
        "measure = \"newton-iterations\"",
        "measure = { history = { column = §\"\" } }",
        "report.ladder.measure.history.column = \"\": must not be empty",
    ),
    ("measure = \"newton-iterations\"", "measure = { field = { name = \"a\", component = §9, statistic = \"max\" } }", "must be 0 to 8"),
    (
        "name = \"regular\", pattern = \"criss-cross\"",
        "name = §\"\", pattern = \"diagonal\"",
        "report.ladder.meshes.0.name = \"\": must not be empty",
    ),
    ("\"criss-cross\" }]", "\"diagonal\" }, { name = §\"regular\", pattern = \"diagonal\" }]", "a mesh of this name comes before"),
    (
        "[report.ladder]",
        "[[report.expect]]\nname = §\"tip\"\nmeasure = \"factorizations\"\nreference = 1\ntolerance = 1\nsource = \"a\"\n[report.ladder]",
        "an expectation of this name comes before",
    ),
    ("mu_perp = 0.002", "mu_perp = §nan", "rest.linear.mu_perp = nan: must be finite"),
    ("resolutions = [1.0, 2.0]", "resolutions = §[]", "report.ladder.resolutions = []: must not be empty"),
    ("resolutions = [1.0, 2.0]", "resolutions = [1.0, §1.0]", "report.ladder.resolutions.1 = 1.0: must be larger than the one before"),
    ("resolutions = [1.0, 2.0]", "resolutions = [§-1.0, 2.0]", "report.ladder.resolutions.0 = -1.0: must be > 0 [1]"),
    ("resolutions = [1.0, 2.0]", "resolutions = [1.0, §3.0]", "report.ladder.resolutions.1 = 3.0: must be the first times 2, 4, 8"),
    ("resolutions = [1.0, 2.0]", "resolutions = [1.5, 3.0, §4.5]", "report.ladder.resolutions.2 = 4.5: must be the first times 2, 4, 8"),
    ("refinement = \"split\"", "refinement = §\"halved\"", "`halved` is not a choice here"),
    ("meets = [\"tip\"]", "meets = [\"tip\", §\"tap\"]", "report.ladder.expect.0.meets.1 = \"tap\": is the name of no [[report.expect]]"),
    ("pattern = \"criss-cross\"", "pattern = \"delaunay\", jitter = §0.1", "report.ladder.meshes.0.jitter = 0.1: cannot be combined"),
    ("thicknesses = [1e-3, 1e-4]", "thicknesses = [1e-3, §0]", "report.ladder.thicknesses.1 = 0: must be > 0 [m]"),
    ("[\"edges\", \"centroid\"]", "[\"edges\", §\"edges\"]", "report.ladder.samplings.1 = \"edges\": comes twice"),
    ("[\"implicit-euler\", \"bdf2\"]", "[\"bdf2\", §\"bdf2\"]", "report.ladder.integrators.1 = \"bdf2\": comes twice"),
    ("integrators = [", "methods = §[\"newton\"]\nintegrators = [", "report.ladder.methods = [\"newton\"]: needs [statics]"),
    ("refinement = \"split\"", "refinement = §\"steps\"", "report.ladder.refinement = \"steps\": `steps` needs steps of one size"),
    (
        "integrator = \"bdf2\"",
        "integrator = §\"generalised-alpha\"",
        "report.ladder.expect.0.integrator = \"generalised-alpha\": is not among those",
    ),
    ("integrator = \"bdf2\"", "method = §\"newton\"", "report.ladder.expect.0.method = \"newton\": is not among those of the ladder"),
    ("[\"edges\", \"centroid\"]", "[\"edges\", §\"faces\"]", "`faces` is not a choice here"),
    ("element = \"quadratic\"", "element = §\"linear\"", "report.ladder.expect.0.element = \"linear\": is not among those of the ladder"),
    ("mesh = \"regular\"", "mesh = §\"irregular\"", "report.ladder.expect.0.mesh = \"irregular\": is not among those of the ladder"),
    ("thickness = 1e-4", "thickness = §2e-4", "report.ladder.expect.0.thickness = 0.0002: is not among those of the ladder"),
    ("sampling = \"edges\"", "sampling = §\"cubic\"", "`cubic` is not a choice here"),
    ("least_order = 1.5", "least_order = §nan", "report.ladder.expect.0.least_order = nan: must be finite"),
    ("largest_error = 100.0", "largest_error = §-1", "report.ladder.expect.0.largest_error = -1: must be >= 0"),
    ("source = \"own bound\"", "source = §\"\"", "report.ladder.expect.0.source = \"\": must not be empty"),
    (
        "[[report.ladder.expect]]",
        "§[[report.ladder.expect]]\nsource = \"a\"\n[[report.ladder.expect]]",
        "report.ladder.expect.0: must give `least_order`, `largest_error` or `meets`",
    ),
    // Sweeps.
    ("name = \"thickness and width\"", "name = §\"\"", "report.sweep.0.name = \"\": must not be empty"),
    ("key = \"shell.thickness\"", "key = §\"shell..thickness\"", "report.sweep.0.key = \"shell..thickness\": must be names joined by dots"),
    (
        "[[report.sweep]]",
        "§[[report.sweep]]\nname = \"none\"\nkey = \"shell.thickness\"\nmeasures = []\n[[report.sweep]]",
        "report.sweep.0: exactly one of `values` and `logarithmic` must be given",
    ),
    (
        "logarithmic = { from = 1e-3, to = 1e-2, count = 3 }",
        "logarithmic = { from = 1e-3, to = 1e-2, count = §1 }",
        "report.sweep.0.logarithmic.count = 1: must be 2 to 1000",
    ),
    ("from = 1e-3, to = 1e-2", "from = §0, to = 1e-2", "report.sweep.0.logarithmic.from = 0: must be > 0"),
    ("from = 1e-3, to = 1e-2", "from = 1e-3, to = §1e-3", "report.sweep.0.logarithmic.to = 0.001: is the same as `from`"),
    ("logarithmic = { from = 1e-3, to = 1e-2, count = 3 }", "values = [1e-3, §inf]", "report.sweep.0.values.1 = inf: must be finite"),
    ("logarithmic = { from = 1e-3, to = 1e-2, count = 3 }", "values = [1e-3, §1e-3]", "report.sweep.0.values.1 = 0.001: comes twice"),
    ("logarithmic = { from = 1e-3, to = 1e-2, count = 3 }", "values = [§[1]]", "expected a number, true, false or a text, found an array"),
    (
        "logarithmic = { from = 1e-3, to = 1e-2, count = 3 }",
        "values = [1e-3, \"2e-3\"]",
        "report.sweep.0.fit: needs two values of the key or more, numbers > 0",
    ),
    ("second = { key = \"mesh.rectangle.size.1\"", "second = { key = §\"shell.thickness\"", "is the first key too"),
    ("least = 0.0, most = 1e3", "least = 0.0, most = §-1", "report.sweep.0.measures.0.most = -1: must not be less than `least`"),
    (", source = \"squares\" }", " }", "`source` and a limit, `least` or `most`, need each other"),
    ("time = 1.0, measure", "time = §-1, measure", "report.sweep.0.measures.1.time = -1: must be >= 0 [s]"),
    ("name = \"left over\"", "name = §\"energy\"", "report.sweep.0.measures.1.name = \"energy\": a measure of this name comes before"),
    ("fit = { measure = \"energy\"", "fit = { measure = §\"work\"", "report.sweep.0.fit.measure = \"work\": is the name of no measure"),
    ("lowest = \"left over\"", "lowest = §\"work\"", "report.sweep.0.fit.lowest = \"work\": is the name of no measure of the sweep"),
    ("kind = \"power\"", "kind = §\"line\"", "`line` is not a choice here"),
    ("exponent = 0.0", "exponent = §inf", "report.sweep.0.fit.expect.exponent = inf: must be finite"),
    ("tolerance = 0.1,", "tolerance = §-1,", "report.sweep.0.fit.expect.tolerance = -1: must be >= 0 [1]"),
    ("source = \"scaling\"", "source = §\"\"", "report.sweep.0.fit.expect.source = \"\": must not be empty"),
    (
        "values = [900, 1000, 1100]",
        "values = §[900]",
        "report.sweep.0.with.0.values = [900]: has 1 values, must have 3 as the key that it goes with",
    ),
    (
        "key = \"shell.density\", values = [900",
        "key = §\"\", values = [900",
        "report.sweep.0.with.0.key = \"\": must be names joined by dots",
    ),
    (
        "set = [\"output.reactions=false\"]",
        "set = [§\"output.reactions\"]",
        "report.sweep.0.set.0 = \"output.reactions\": `key=value` expected",
    ),
    ("shapes = { time = 0.75 }", "shapes = { time = §-1 }", "report.sweep.0.shapes.time = -1: must be >= 0 [s]"),
    (
        "shapes = { time",
        "largest = { measure = §\"work\", least = 1 }\nshapes = { time",
        "report.sweep.0.largest.measure = \"work\": is the name of no measure",
    ),
    (
        "shapes = { time",
        "largest = §{ measure = \"energy\", least = 1 }\nshapes = { time",
        "report.sweep.0.largest = { measure = \"energy\", least = 1 }: needs a second key whose values are numbers",
    ),
    // Matrices.
    ("most_factorizations = 5000", "most_factorizations = §0", "report.matrix.most_factorizations = 0: must be >= 1"),
    ("most_iterations = 40.0", "most_iterations = §0", "report.matrix.most_iterations = 0: must be > 0 [1]"),
    ("largest_energy = 0.5", "largest_energy = §nan", "report.matrix.largest_energy = nan: must be > 0 [1]"),
    ("largest_gain = 1e-7", "largest_gain = §-1", "report.matrix.largest_gain = -1: must be >= 0 [1]"),
    ("most_seconds = 30.0", "most_seconds = §1e7", "report.matrix.most_seconds = 10000000.0: must be 0 to 1000000"),
    ("name = \"moduli\"", "name = §\"\"", "report.matrix.part.0.name = \"\": must not be empty"),
    (
        "set = [\"output.interval=0.25\"]",
        "set = [§\"output.interval\"]",
        "report.matrix.part.0.set.0 = \"output.interval\": `key=value` expected",
    ),
    ("key = \"shell.youngs_modulus\"", "key = §\"shell.\"", "report.matrix.part.0.axes.0.key = \"shell.\": must be names joined by dots"),
    ("values = [1e3, 1e12]", "values = §[]", "report.matrix.part.0.axes.0.values = []: must not be empty"),
    (
        "values = [10, 100]",
        "values = §[10]",
        "report.matrix.part.0.axes.0.with.0.values = [10]: has 1 values, must have 2 as the key that it goes with",
    ),
    ("ends = \"either\"", "ends = §\"somehow\"", "`somehow` is not a choice here"),
    ("name = \"lift\"", "name = §\"\"", "report.matrix.measures.0.name = \"\": must not be empty"),
    // Random velocities.
    ("speed = 0.7", "speed = §-0.7", "dynamics.random_velocity.speed = -0.7: must be > 0 [m/s]"),
    ("seed = 11", "seed = §-1", "expected a whole number"),
    // Measures.
    ("over = \"E * h^3\"", "over = §\"E * x\"", "measures.0.measure.energy.over = \"E * x\": unknown name `x`; variables here: h, E, nu"),
    ("over = \"E * h^3\"", "over = §0", "measures.0.measure.energy.over = 0: must be > 0 [J]"),
    ("part = \"bending\"", "part = §\"kinetic\"", "`kinetic` is not a choice here"),
    ("part = \"total\"", "part = §\"all\"", "`all` is not a choice here"),
    ("\"0.01 * r\"", "§\"0.01 * t\"", "surface-distance.position.2 = \"0.01 * t\": unknown name `t`; variables here: x, y, z, r, theta"),
    ("over = 1.02", "over = §0", "surface-distance.over = 0: must be > 0 [m]"),
    ("{ waves = { region = \"boundary\" } }", "{ original-distance = { over = §-1 } }", "original-distance.over = -1: must be > 0 [m]"),
    ("kind = \"hausdorff\"", "kind = §\"frechet\"", "`frechet` is not a choice here"),
    ("mirror = false", "mirror = §1", "surface-distance.mirror = 1: expected a boolean, found integer"),
    ("of = \"gauss\"", "of = §\"ricci\"", "`ricci` is not a choice here"),
    ("weighting = \"sum\"", "weighting = §\"max\"", "`max` is not a choice here"),
    ("{ waves = { region = \"boundary\" } }", "{ waves = { region = §\"\" } }", "waves.region = \"\": must not be empty"),
    (
        "{ wave-amplitude = { region = \"boundary\" } }",
        "{ wave-amplitude = { region = §\"\" } }",
        "wave-amplitude.region = \"\": must not be empty",
    ),
    ("a = [0, 0, 0]", "a = §[0, 0, nan]", "distance-between.a = [0, 0, nan]: must be finite"),
    ("b = [1, 0, 0]", "b = §[inf, 0, 0]", "distance-between.b = [inf, 0, 0]: must be finite"),
    ("statistic = \"median\", region = \"tip\"", "statistic = \"median\", region = §\"\"", "field.region = \"\": must not be empty"),
    ("statistic = \"median\"", "statistic = §\"mode\"", "`mode` is not a choice here"),
];

/// What only the mesh of the full scene can tell: the same, without a place.
const WRONG_ON_THE_MESH: &[(&str, &str, &str)] = &[
    (
        "{ waves = { region = \"boundary\" } }",
        "{ waves = { region = \"left\" } }",
        "waves.region = \"left\": region 'left' is not a closed loop",
    ),
    ("{ wave-amplitude = { region = \"boundary\" } }", "{ wave-amplitude = { region = \"corner\" } }", "region 'corner' has no edges"),
    ("{ waves = { region = \"boundary\" } }", "{ waves = { region = \"rim\" } }", "there is no region 'rim'"),
    ("b = [1, 0, 0]", "b = [9, 0, 0]", "distance-between.b = [9, 0, 0]: the vertex nearest to (9, 0, 0) m is 8.000e0 m away"),
    ("\"0.01 * r\"", "\"1 / r\"", "surface-distance.position.2 = \"1 / r\": is inf at (0, 0, 0) m"),
    (
        "{ waves = { region = \"boundary\" } }",
        "{ original-distance = {} }",
        "measures.4.measure.original-distance = {}: there is no field 'original_position'",
    ),
    ("over = \"E * h^3\"", "over = \"h - 1\"", "energy.over = \"h - 1\": is -0.999 J for this shell, must be > 0"),
    ("statistic = \"median\", region = \"tip\"", "statistic = \"median\", region = \"left\"", "region 'left' has no faces"),
];

/// Meshes in place of the full scene's rectangle; the ladder's variants go, since they need one.
const WRONG_MESHES: &[(&str, &str)] = &[
    ("disc = { radius = §0, rings = 3 }", "mesh.disc.radius = 0: must be > 0 [m]"),
    ("disc = { radius = 1, rings = §0 }", "mesh.disc.rings = 0: must be 1 to 5000"),
    ("annulus = { radii = [1, §1], cells = [1, 3] }", "mesh.annulus.radii.1 = 1: must be larger than the inner radius"),
    ("annulus = { radii = [1, 2], cells = [1, §2] }", "mesh.annulus.cells.1 = 2: must be 3 to 10000"),
    ("annulus = { radii = [1, 2], cells = [1, 3], pattern = §\"delaunay\" }", "mesh.annulus.pattern = \"delaunay\": `delaunay` exists"),
    ("cylinder = { radius = 1, length = §-1, cells = [3, 1] }", "mesh.cylinder.length = -1: must be > 0 [m]"),
    ("cylinder = { radius = 1, length = 1, cells = [§2, 1] }", "mesh.cylinder.cells.0 = 2: must be 3 to 10000"),
    ("cylinder = { radius = 1, length = 1, angle = §361, cells = [3, 1] }", "mesh.cylinder.angle = 361: must be > 0 and <= 360"),
    ("sphere-cap = { radius = 1, half_angle = §180, rings = 2 }", "mesh.sphere-cap.half_angle = 180: must be > 0 and < 180"),
    ("outline = { points = §[[0, 0], [1, 0]], triangulation = { size = 1 } }", "has 2 corners, must have at least 3"),
    (
        "outline = { points = [[0, 0], [1, 0], §[0, 0]], triangulation = { size = 1 } }",
        "mesh.outline.points.2 = [0, 0]: is the same as the next",
    ),
    (
        "outline = { points = [[0, 0], [1, 0], [0, 1]], holes = [§[]], triangulation = { size = 1 } }",
        "mesh.outline.holes.0 = []: has 0 corners",
    ),
    ("file = { path = §\"\" }", "mesh.file.path = \"\": must not be empty"),
    ("file = { path = \"a.obj\", scale = §0 }", "mesh.file.scale = 0: must be > 0"),
    ("disc = { radius = 1, rings = 3 }", "report.ladder.meshes.0 = "),
];

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_thinshell")).args(arguments).current_dir(folder).output().expect("the program starts")
}

/// Gives the text to the program; the message must be one, at `§`, contain `expected`, and nothing may be written.
fn refuse(text: &str, expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text.replace('§', "")).unwrap();
    let output = run(folder.path(), &["all", "scene.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{expected}: {message}");
    assert!(output.stdout.is_empty());
    let place = text.find('§').map_or(String::new(), |at| {
        let before = &text[..at];
        format!("{}:{}:", before.matches('\n').count() + 1, at - before.rfind('\n').map_or(0, |end| end + 1) + 1)
    });
    assert!(message.starts_with(&format!("error: scene.toml:{place}")), "expected {place} {expected}, found {message}");
    assert!(message.contains(expected), "expected {expected}, found {message}");
    assert_eq!(message.matches("error:").count(), 1, "{message}");
    assert!(message.lines().skip(1).all(|line| line.starts_with("  help: ")), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{expected}: something was written");
}

#[test]
fn every_rule_is_kept() {
    for (part, wrong, expected) in WRONG {
        assert_eq!(FULL.matches(part).count(), 1, "{part:?} must be one part of the full scene");
        refuse(&FULL.replace(part, wrong), expected);
    }
}

#[test]
fn every_rule_on_the_mesh_is_kept() {
    for (part, wrong, expected) in WRONG_ON_THE_MESH {
        assert_eq!(FULL.matches(part).count(), 1, "{part:?} must be one part of the full scene");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), FULL.replace(part, wrong)).unwrap();
        let output = run(folder.path(), &["all", "scene.toml"]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{expected}: {message}");
        assert!(message.contains(expected) && message.contains("report.sweep.0.measures."), "expected {expected}, found {message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{expected}: something was written");
    }
}

#[test]
fn every_rule_for_meshes_is_kept() {
    let tail = &FULL[FULL.find("[[region]]").unwrap()..];
    for (wrong, expected) in WRONG_MESHES {
        refuse(&format!("[mesh]\n{wrong}\n\n{tail}"), expected);
    }
}

#[test]
fn gravity_and_dynamics_need_a_density() {
    let without = FULL.replace("density = 1000.0\n", "").replace("[shell]\n", "§[shell]\n");
    refuse(&without, "shell.density: this key is missing, and [dynamics] needs it");
    let head = &without[..without.find("[dynamics]").unwrap()];
    let without = format!("{}[statics]\n", head.replace("viscosity = 0.01\n", ""));
    refuse(&without, "shell.density: this key is missing, and [gravity] needs it");
}

#[test]
fn statics_knows_no_viscosity() {
    let head = &FULL[..FULL.find("[dynamics]").unwrap()];
    refuse(&format!("{}[statics]\n", head.replace("= 0.01", "= §0.01")), "shell.viscosity = 0.01: has no meaning without [dynamics]");
    let quiet = head.replace("viscosity = 0.01\n", "");
    refuse(&format!("{quiet}[statics]\nsteps = §0\n"), "statics.steps = 0: must be 1 to 100000");
    refuse(&format!("{quiet}[statics]\n§velocity = 1\n"), "statics.velocity: unknown key");
    let relaxed = format!("{quiet}[statics]\nmethod = §\"dynamic-relaxation\"\n");
    refuse(&format!("{relaxed}stable = true\n"), "statics.method = \"dynamic-relaxation\": `dynamic-relaxation` goes without `stable`");
    let relaxed = relaxed.replace('§', "");
    refuse(&format!("{quiet}[statics]\nrelaxation = §{{ tolerance = 1e-6 }}\n"), "needs `method = \"dynamic-relaxation\"`");
    refuse(&format!("{relaxed}relaxation = {{ tolerance = §0.1 }}\n"), "statics.relaxation.tolerance = 0.1: must be");
    refuse(&format!("{relaxed}relaxation = {{ max_iterations = §0 }}\n"), "statics.relaxation.max_iterations = 0: must be 1 to 1000000000");
}

#[test]
fn unreadable_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    std::fs::create_dir(folder.path().join("folder.toml")).unwrap();
    write("empty.toml", b" \n");
    write("binary.toml", b"\x7fELF\x02\x01\x01\0\0\0");
    write("latin.toml", b"title = \"a\"\nname = \"caf\xe9\"\n");
    std::fs::File::create(folder.path().join("large.toml")).unwrap().set_len(11 << 20).unwrap();
    for (name, expected) in [
        ("missing.toml", "cannot read missing.toml"),
        ("folder.toml", "this is a folder"),
        ("empty.toml", "the file is empty"),
        ("binary.toml", "binary"),
        ("latin.toml", "not UTF-8 text, first on line 2"),
        ("large.toml", "10 MB"),
    ] {
        let output = run(folder.path(), &["all", name]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(name) && message.contains(expected) && message.lines().count() == 1, "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5, "something was written");
}
