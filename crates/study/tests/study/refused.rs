//! Malformed and absurd studies, each with the message of the reader.

use study::{NamedFile, Study};

/// A good study; every case below spoils it in one way.
const GOOD: &str = r#"name = "good"
question = "Does it read?"

[scene.foundation]
base = { shear_modulus = "80 GPa", poisson = 0.3 }
[scene.punch]
shape = "sphere"
radius = "10 mm"
[scene.friction]
mu = 0.3
[scene.loading]
steps = [{ approach = "1 um" }]

[numerics]
mesh = 16

[sweep]
"friction.mu" = [0.1, 0.2]
"#;

/// The name of each case, the text that is replaced, and its replacement.
const CASES: &[(&str, &str, &str)] = &[
    ("not TOML", "mesh = 16", "mesh = = 16"),
    ("unclosed text", "\"good\"", "\"good"),
    ("key twice", "mesh = 16", "mesh = 16\nmesh = 32"),
    ("table twice", "[sweep]", "[numerics]\ntolerance = 1e-8\n[sweep]"),
    ("empty file", GOOD, ""),
    ("no name", "name = \"good\"\n", ""),
    ("name with a slash", "\"good\"", "\"../good\""),
    ("empty name", "\"good\"", "\"\""),
    ("name is a number", "\"good\"", "7"),
    ("question is a list", "\"Does it read?\"", "[\"Does it read?\"]"),
    ("unknown kind", "question =", "kind = \"guess\"\nquestion ="),
    ("misspelt kind", "question =", "kind = \"uniquenes\"\nquestion ="),
    ("uniqueness of what the load decides", "question =", "kind = \"uniqueness\"\nquestion ="),
    ("starts of a solution", "[sweep]", "[search]\nstarts = 3\n[sweep]"),
    ("convergence along nothing", "question =", "kind = \"convergence\"\nquestion ="),
    ("convergence table of another kind", "[sweep]", "[convergence]\nalong = \"mesh\"\n[sweep]"),
    ("cost table of another kind", "[sweep]", "[cost]\nrepeat = 3\n[sweep]"),
    (
        "figure of points by a column that is not there",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = \"load\"\nwhere = \"creepage_x == 0\"\n[sweep]",
    ),
    (
        "figure of points by no condition",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = \"load\"\nwhere = \"mu + 1\"\n[sweep]",
    ),
    (
        "histogram of points by a text that is a number",
        "[sweep]",
        "[figure]\nkind = \"histogram\"\nx = \"load\"\nwhere = \"status > 3\"\n[sweep]",
    ),
    (
        "refine and bisect",
        "[sweep]",
        "[refine]\non = \"load\"\nuntil = 0.1\n[bisect]\naxis = \"mu\"\non = \"load > 0\"\nto = 0.1\n[sweep]",
    ),
    ("refine on a text", "[sweep]", "[refine]\non = \"status\"\nuntil = \"1%\"\n[sweep]"),
    ("refine until more than all", "[sweep]", "[refine]\non = \"laod\"\nuntil = \"100%\"\n[sweep]"),
    (
        "refine an axis of meshes",
        "\"friction.mu\" = [0.1, 0.2]",
        "mesh = [8, 16]\n[refine]\non = \"load\"\nuntil = \"1%\"",
    ),
    (
        "refine without an end",
        "[sweep]",
        "[refine]\non = \"load\"\nat_most = 6.5\nhow = 3\n[sweep]",
    ),
    (
        "refine up to nothing",
        "[sweep]",
        "[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = 0\n[sweep]",
    ),
    (
        "refine up to a mesh not twice as fine",
        "[sweep]",
        "[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = 31\n[sweep]",
    ),
    (
        "refine beyond every mesh",
        "[sweep]",
        "[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = 4097\n[sweep]",
    ),
    (
        "refine up to a text",
        "[sweep]",
        "[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = \"64\"\n[sweep]",
    ),
    (
        "refine a fine mesh without an end",
        "mesh = 16\n",
        "mesh = [64, 600]\n[refine]\non = \"load\"\nuntil = \"1%\"\n",
    ),
    (
        "refine the finest mesh",
        "mesh = 16\n",
        "mesh = 2049\n[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = 4096\n",
    ),
    (
        "refine on what is compared",
        GOOD,
        "name = \"x\"\nkind = \"convergence\"\n[scene]\nfoundation.base = { shear_modulus = 1, poisson = 0 }\n\
         punch = { shape = \"sphere\", radius = 1 }\nfriction.mu = 0\nloading.steps = [{ approach = 1 }]\n\
         [numerics]\nmesh = 8\n[sweep]\nepsilon = [0, 1e-3]\n[refine]\non = \"error_load\"\nuntil = \"1%\"",
    ),
    (
        "bisect no axis",
        "[sweep]",
        "[bisect]\naxis = \"radius\"\non = \"load > 0\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "bisect falling values",
        "[0.1, 0.2]",
        "[0.2, 0.1]\n[bisect]\naxis = \"mu\"\non = \"load > 0\"\nto = \"1%\"",
    ),
    (
        "bisect whole numbers",
        "\"friction.mu\" = [0.1, 0.2]",
        "mesh = [8, 16]\n[bisect]\naxis = \"mesh\"\non = \"load > 0\"\nto = \"1%\"",
    ),
    (
        "find without a value",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    ("find nothing", "[sweep]", "[find]\nhow = 3\n[sweep]"),
    (
        "find in a misspelt column",
        "[sweep]",
        "[find]\ncolumn = \"stick_fracton\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find in a text",
        "[sweep]",
        "[find]\ncolumn = \"status\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find what the study gives",
        "[sweep]",
        "[find]\ncolumn = \"radius\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find what differs from run to run",
        "[sweep]",
        "[find]\ncolumn = \"seconds\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find a force in a pressure",
        "[sweep]",
        "[find]\ncolumn = \"peak_pressure\"\nvalue = \"1 kN\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find a pure number with a unit",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = \"0.5 mm\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find a pure number in quotes",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = \"0.5\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find a force without its unit",
        "[sweep]",
        "[find]\ncolumn = \"load\"\nvalue = \"12\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find no number",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = nan\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find along what is no axis",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"radius\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "find to more than all",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"200%\"\n[sweep]",
    ),
    (
        "find by a word",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"soon\"\n[sweep]",
    ),
    (
        "find along falling values",
        "[0.1, 0.2]",
        "[0.2, 0.1]\n[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n",
    ),
    (
        "find along one value",
        "[0.1, 0.2]",
        "[0.1]\n[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n",
    ),
    (
        "find along meshes",
        "\"friction.mu\" = [0.1, 0.2]",
        "mesh = [8, 16]\n[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mesh\"\nto = \"1%\"\n",
    ),
    (
        "find along axes that advance together",
        "[sweep]\n\"friction.mu\" = [0.1, 0.2]",
        "[[sweep.zip]]\n\"friction.mu\" = [0.1, 0.2]\n\"punch.radius\" = [1, 2]\n[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n",
    ),
    (
        "find in a study without axes",
        "[sweep]\n\"friction.mu\" = [0.1, 0.2]\n",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n",
    ),
    (
        "find and fill",
        "[sweep]",
        "[find]\ncolumn = \"stick_fraction\"\nvalue = 0.5\naxis = \"mu\"\nto = \"1%\"\n[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    ("find in the numerics", "mesh = 16", "mesh = 16\nfind = 3"),
    ("find in a list", "[sweep]", "[[find]]\ncolumn = \"load\"\n[sweep]"),
    ("fill without an end", "[sweep]", "[fill]\ncolumn = \"load\"\naxis = \"mu\"\n[sweep]"),
    ("fill without an axis", "[sweep]", "[fill]\ncolumn = \"load\"\nto = \"1%\"\n[sweep]"),
    (
        "fill along three axes",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = [\"mu\", \"mu\", \"mu\"]\nto = \"1%\"\n[sweep]",
    ),
    (
        "fill along an axis twice",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = [\"mu\", \"mu\"]\nto = \"1%\"\n[sweep]",
    ),
    ("fill along no axis", "[sweep]", "[fill]\ncolumn = \"load\"\naxis = []\nto = \"1%\"\n[sweep]"),
    (
        "fill along a number",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = [1]\nto = \"1%\"\n[sweep]",
    ),
    ("fill to nothing", "[sweep]", "[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = 0\n[sweep]"),
    (
        "fill with no point",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = \"1%\"\nat_most = 0\n[sweep]",
    ),
    (
        "fill with too many points",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = \"1%\"\nat_most = 1_000_000\n[sweep]",
    ),
    (
        "fill with a part of a point",
        "[sweep]",
        "[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = \"1%\"\nat_most = 2.5\n[sweep]",
    ),
    (
        "fill a column of texts",
        "[sweep]",
        "[fill]\ncolumn = \"reason\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "fill what a mesh is",
        "[sweep]",
        "[fill]\ncolumn = \"mesh\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    (
        "fill beside an accuracy",
        "mesh = 16\n\n[sweep]",
        "\n[accuracy]\nis = 0.01\n[fill]\ncolumn = \"load\"\naxis = \"mu\"\nto = \"1%\"\n[sweep]",
    ),
    ("branch of a scene that is solved", "[sweep]", "[branch]\nto = \"1%\"\n[sweep]"),
    ("accuracy beside a mesh", "question =", "accuracy = \"0.1%\"\nquestion ="),
    (
        "accuracy beside an axis of meshes",
        "mesh = 16\n\n[sweep]",
        "\n[accuracy]\nis = 0.01\n[sweep]\nmesh = [8, 16]",
    ),
    ("accuracy of more than all", "mesh = 16", "[accuracy]\nis = \"100%\"\nat_most = 4\nhow = 1"),
    ("accuracy of nothing known", "mesh = 16", "[accuracy]\nof = \"peak_presure\"\nis = \"1%\""),
    (
        "accuracy of what the scene gives",
        "mesh = 16",
        "[accuracy]\nof = \"estimate_approach\"\nis = \"1%\"",
    ),
    ("accuracy without a number", "mesh = 16", "[accuracy]\nof = \"load\"\nat_most = 64.5"),
    ("accuracy as a list", GOOD, "name = \"x\"\naccuracy = [0.1]"),
    (
        "accuracy of a peak without limit",
        GOOD,
        "name = \"x\"\n[accuracy]\nof = \"peak_pressure\"\nis = 0.01\n[scene]\nfoundation.base = { shear_modulus = 1, poisson = 0 }\n\
         punch = { shape = \"cone\", angle = \"1 deg\" }\nfriction.mu = 0\nloading.steps = [{ approach = 1 }]",
    ),
    (
        "accuracy and refine",
        "mesh = 16",
        "[accuracy]\nis = 0.01\n[refine]\non = \"load\"\nuntil = \"1%\"",
    ),
    ("accuracy of another kind", GOOD, "name = \"x\"\nkind = \"multiplicity\"\naccuracy = 0.01"),
    ("accuracy among the numerics", "mesh = 16", "mesh = 16\naccuracy = 0.01"),
    ("band of one column", "[sweep]", "[figure]\nx = \"mu\"\nband = [\"load\"]\n[sweep]"),
    ("misspelt table", "[numerics]", "[numerik]"),
    ("misspelt key", "radius =", "raduis ="),
    ("key of nothing", "mu = 0.3", "mu = 0.3\ncolour = \"red\""),
    ("key at the top", "name = \"good\"", "name = \"good\"\nmesh = 16"),
    ("scene is a number", GOOD, "name = \"x\"\nscene = 3\nnumerics = 4"),
    (
        "table is a text",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "material = \"steel\"\nshape = \"sphere\"\nradius = \"10 mm\"",
    ),
    (
        "rigid base without a layer",
        "base = { shear_modulus = \"80 GPa\", poisson = 0.3 }",
        "base = \"rigid\"",
    ),
    ("misspelt rigid", "base = { shear_modulus = \"80 GPa\", poisson = 0.3 }", "base = \"rigd\""),
    ("base is a number", "base = { shear_modulus = \"80 GPa\", poisson = 0.3 }", "base = 80e9"),
    (
        "no base",
        "base = { shear_modulus = \"80 GPa\", poisson = 0.3 }",
        "layers = [{ shear_modulus = 1, poisson = 0, thickness = 1 }]",
    ),
    (
        "layer without thickness",
        "base =",
        "layers = [{ shear_modulus = \"8 GPa\", poisson = 0.3 }]\nbase =",
    ),
    (
        "layer without extent",
        "base =",
        "layers = [{ shear_modulus = \"8 GPa\", poisson = 0.3, thickness = 0 }]\nbase =",
    ),
    (
        "Poisson above a half in a layer",
        "base =",
        "layers = [{ shear_modulus = \"8 GPa\", poisson = 0.7, thickness = 1 }]\nbase =",
    ),
    (
        "misspelt key of a layer",
        "base =",
        "layers = [{ shear_modulus = \"8 GPa\", poisson = 0.3, thikness = 1 }]\nbase =",
    ),
    ("layer is a number", "base =", "layers = [1]\nbase ="),
    (
        "layers is a table",
        "base =",
        "layers = { shear_modulus = \"8 GPa\", poisson = 0.3, thickness = 1 }\nbase =",
    ),
    (
        "index in a name",
        "base =",
        "\"layers[0]\" = { shear_modulus = \"8 GPa\", poisson = 0.3, thickness = 1 }\nbase =",
    ),
    ("pressure in millimetres", "80 GPa", "5 mm"),
    ("unknown unit", "10 mm", "10 furlong"),
    ("unit in the wrong case", "80 GPa", "80 gpa"),
    ("millipascal", "80 GPa", "80 mPa"),
    ("text without unit", "\"10 mm\"", "\"10\""),
    ("unit without number", "\"10 mm\"", "\"mm\""),
    ("unit on a pure number", "poisson = 0.3", "poisson = \"0.3 mm\""),
    ("pure number in quotes", "poisson = 0.3", "poisson = \"0.3\""),
    ("length is true", "\"10 mm\"", "true"),
    ("length is a list", "\"10 mm\"", "[\"10 mm\"]"),
    ("length is a date", "\"10 mm\"", "2024-01-01"),
    ("length is not a number", "\"10 mm\"", "nan"),
    ("length is infinite", "\"10 mm\"", "-inf"),
    ("length overflows", "\"10 mm\"", "1e999"),
    ("text overflows", "\"10 mm\"", "\"1e999 mm\""),
    ("negative radius", "\"10 mm\"", "\"-10 mm\""),
    ("zero modulus", "\"80 GPa\"", "0"),
    ("Poisson above a half", "poisson = 0.3", "poisson = 0.6"),
    ("negative Poisson", "poisson = 0.3", "poisson = -0.1"),
    (
        "negative friction",
        "mu = 0.3\n[scene.loading]\nsteps = [{ approach = \"1 um\" }]\n\n[numerics]\nmesh = 16\n\n[sweep]\n\"friction.mu\" = [0.1, 0.2]",
        "mu = -0.3\n[scene.loading]\nsteps = [{ approach = \"1 um\" }]\n\n[numerics]\nmesh = 16",
    ),
    ("unknown shape", "\"sphere\"", "\"spere\""),
    ("shape of nothing", "\"sphere\"", "\"banana\""),
    ("no shape", "shape = \"sphere\"\n", ""),
    ("no radius", "radius = \"10 mm\"\n", ""),
    ("key of another shape", "radius =", "angle = \"5 deg\"\nradius ="),
    ("shape with the wrong keys", "\"sphere\"", "\"ellipsoid\""),
    (
        "vertical cone",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"cone\"\nangle = \"90 deg\"",
    ),
    (
        "cone in millimetres",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"cone\"\nangle = \"5 mm\"",
    ),
    ("half a material", "radius = \"10 mm\"", "radius = \"10 mm\"\nmaterial = { poisson = 0.3 }"),
    ("half a domain", "[numerics]", "[scene.domain]\nwidth_x = \"1 mm\"\n[numerics]"),
    (
        "no foundation",
        "[scene.foundation]\nbase = { shear_modulus = \"80 GPa\", poisson = 0.3 }\n",
        "",
    ),
    ("no approach", "approach = \"1 um\"", "shift_x = \"1 um\""),
    ("no steps", "[{ approach = \"1 um\" }]", "[]"),
    (
        "approach and its force",
        "approach = \"1 um\"",
        "approach = \"1 um\", normal_force = \"1 kN\"",
    ),
    (
        "shift and its force in the second step",
        "[{ approach = \"1 um\" }]",
        "[{ approach = \"1 um\" }, { shift_y = 0, force_y = 1 }]",
    ),
    ("force of 0", "approach = \"1 um\"", "normal_force = 0"),
    ("force in millimetres", "approach = \"1 um\"", "normal_force = \"1 mm\""),
    (
        "moment in newtons",
        "[{ approach = \"1 um\" }]",
        "[{ approach = \"1 um\" }, { moment_z = \"1 N\" }]",
    ),
    (
        "misspelt key of a step",
        "[{ approach = \"1 um\" }]",
        "[{ approach = \"1 um\" }, { shfit_x = 0 }]",
    ),
    ("no increments", "approach = \"1 um\"", "approach = \"1 um\", increments = 0"),
    ("half an increment", "approach = \"1 um\"", "approach = \"1 um\", increments = 0.5"),
    (
        "too many increments",
        "[{ approach = \"1 um\" }]",
        "[{ approach = \"1 um\", increments = 600 }, { shift_x = 1, increments = 600 }]",
    ),
    ("cycles from nowhere", "steps =", "cycles = 3\nsteps ="),
    ("cycle from a step that is not there", "steps =", "cycle_from = 1\nsteps ="),
    ("no cycles", "steps =", "cycle_from = 0\ncycles = 0\nsteps ="),
    ("no loading", "[scene.loading]\nsteps = [{ approach = \"1 um\" }]", ""),
    ("steps is a table", "[{ approach = \"1 um\" }]", "{ approach = \"1 um\" }"),
    ("step is a text", "[{ approach = \"1 um\" }]", "[\"1 um\"]"),
    ("force as approach", "approach = \"1 um\"", "approach = \"1 kN\""),
    ("no mesh", "mesh = 16\n", "tolerance = 1e-8\n"),
    ("mesh of 0", "mesh = 16", "mesh = 0"),
    ("negative mesh", "mesh = 16", "mesh = -3"),
    ("huge mesh", "mesh = 16", "mesh = 5000"),
    ("mesh beyond every integer", "mesh = 16", "mesh = 99999999999999999999"),
    ("broken mesh", "mesh = 16", "mesh = 16.5"),
    ("mesh of three sides", "mesh = 16", "mesh = [16, 16, 16]"),
    ("mesh in quotes", "mesh = 16", "mesh = \"16\""),
    ("tolerance of 1", "mesh = 16", "mesh = 16\ntolerance = 1.0"),
    ("no iterations", "mesh = 16", "mesh = 16\nmax_iterations = 0"),
    ("unknown method", "mesh = 16", "mesh = 16\nmethod = \"krylov\""),
    ("unknown projection", "mesh = 16", "mesh = 16\nprojection = \"midpint\""),
    ("negative ceiling", "mesh = 16", "mesh = 16\nceiling = \"-1 GPa\""),
    ("empty axis", "[0.1, 0.2]", "[]"),
    ("axis of one bare value", "[0.1, 0.2]", "0.1"),
    ("axis on no key", "\"friction.mu\" =", "\"friction.nu\" ="),
    ("axis on a last segment", "\"friction.mu\" =", "mu ="),
    ("axis on nothing", "\"friction.mu\" =", "\"weather.wind\" ="),
    (
        "axis on a step that is not there",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"loading.steps[1].shift_x\" = [0, 1]",
    ),
    (
        "axis on the last step that can be written",
        "\"friction.mu\" =",
        "\"loading.steps[4294967295].shift_x\" =",
    ),
    (
        "axis on a layer far beyond none",
        "\"friction.mu\" =",
        "\"foundation.layers[4000000000].thickness\" =",
    ),
    (
        "axis on the last whole layer that can be written",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.layers[4294967295]\" = [{ label = \"a\", thickness = 1 }]",
    ),
    (
        "axis on a whole step that is not there",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"loading.steps[4]\" = [{ label = \"a\", shift_x = 0 }]",
    ),
    (
        "axis on a step beyond those of the axes",
        "[scene.loading]\nsteps = [{ approach = \"1 um\" }]\n\n[numerics]\nmesh = 16\n\n[sweep]",
        "[numerics]\nmesh = 16\n\n[sweep]\n\"loading.steps[0].approach\" = [1, 2]\n\"loading.steps[2].shift_x\" = [1, 2]",
    ),
    (
        "axis on a layer that is not there",
        "\"friction.mu\" =",
        "\"foundation.layers[0].thickness\" =",
    ),
    ("axis on a key of a step that is none", "\"friction.mu\" =", "\"loading.steps[0].shfit_x\" ="),
    ("axis on a step without a number", "\"friction.mu\" =", "\"loading.steps[first].shift_x\" ="),
    (
        "axis of half increments",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"loading.steps[0].increments\" = [1, 1.5]",
    ),
    (
        "axis of increments that are too many",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"loading.steps[0].increments\" = [1, 10, 10000]",
    ),
    (
        "elastic base without a name",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.base\" = [\"rigid\", { shear_modulus = 1, poisson = 0 }]",
    ),
    (
        "modulus of a rigid base",
        "base = { shear_modulus = \"80 GPa\", poisson = 0.3 }\n[scene.punch]\nshape = \"sphere\"\nradius = \"10 mm\"\n[scene.friction]\nmu = 0.3\n[scene.loading]\nsteps = [{ approach = \"1 um\" }]\n\n[numerics]\nmesh = 16\n\n[sweep]\n\"friction.mu\" = [0.1, 0.2]",
        "base = \"rigid\"\nlayers = [{ shear_modulus = 1, poisson = 0, thickness = 1 }]\n[scene.punch]\nshape = \"sphere\"\nradius = \"10 mm\"\n[scene.friction]\nmu = 0.3\n[scene.loading]\nsteps = [{ approach = \"1 um\" }]\n\n[numerics]\nmesh = 16\n\n[sweep]\n\"foundation.base.poisson\" = [0.1, 0.2]",
    ),
    (
        "layers that are no lists",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.layers\" = [{ shear_modulus = 1, poisson = 0, thickness = 1 }]",
    ),
    (
        "lists of layers of one name",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.layers\" = [[{ shear_modulus = 1, poisson = 0, thickness = 1 }], [{ shear_modulus = 2, poisson = 0, thickness = 1 }]]",
    ),
    (
        "layers without their label",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.layers\" = [{ layers = [] }]",
    ),
    (
        "layers with more than their label",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.layers\" = [{ label = \"a\", layers = [], base = \"rigid\" }]",
    ),
    (
        "axis on a step inside an axis on the loading",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"loading.steps[0].approach\" = [1, 2]\nloading = [{ label = \"a\", steps = [{ approach = 1 }] }]",
    ),
    ("axis of texts on a number", "[0.1, 0.2]", "[\"low\", \"high\"]"),
    (
        "axis of the wrong unit",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"punch.radius\" = [\"1 mm\", \"1 MPa\"]",
    ),
    ("axis with a bad value", "[0.1, 0.2]", "[0.1, -0.2, 0.3, nan]"),
    (
        "axis with two bad values",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.base.poisson\" = [0.1, 0.6, 0.2, 0.7]",
    ),
    (
        "axis that repeats itself",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"punch.radius\" = [\"1 mm\", 0.001]",
    ),
    ("axis twice", "\"friction.mu\" = [0.1, 0.2]", "mesh = [16, 32]\n\"numerics.mesh\" = [8, 9]"),
    ("axis inside an axis", "[0.1, 0.2]", "[0.1, 0.2]\nfriction = [{ mu = 0.1, label = \"low\" }]"),
    ("sweep is a list", "[sweep]\n\"friction.mu\" = [0.1, 0.2]", "[[sweep]]\nmesh = 1"),
    ("range without count", "[0.1, 0.2]", "{ from = 0.1, to = 0.2 }"),
    ("range of 0", "[0.1, 0.2]", "{ from = 0.1, to = 0.2, count = 0 }"),
    ("range of 1", "[0.1, 0.2]", "{ from = 0.1, to = 0.2, count = 1 }"),
    ("range of half a value", "[0.1, 0.2]", "{ from = 0.1, to = 0.2, count = 2.5 }"),
    ("range that goes nowhere", "[0.1, 0.2]", "{ from = 0.1, to = 0.1, count = 3 }"),
    ("range with a misspelt key", "[0.1, 0.2]", "{ form = 0.1, to = 0.2, count = 3 }"),
    (
        "range with equal ratios from 0",
        "[0.1, 0.2]",
        "{ log = true, from = 0, to = 0.2, count = 3 }",
    ),
    (
        "range with log in quotes",
        "[0.1, 0.2]",
        "{ log = \"yes\", from = 0.1, to = 0.2, count = 3 }",
    ),
    (
        "range of words",
        "\"friction.mu\" = [0.1, 0.2]",
        "projection = { from = 1, to = 2, count = 2 }",
    ),
    (
        "range of broken meshes",
        "\"friction.mu\" = [0.1, 0.2]",
        "mesh = { log = true, from = 16, to = 64, count = 4 }",
    ),
    (
        "range that leaves what is allowed",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.base.poisson\" = { from = 0.3, to = 0.6, count = 4 }",
    ),
    ("range to infinity", "[0.1, 0.2]", "{ from = 0.1, to = inf, count = 3 }"),
    (
        "too many points",
        "[0.1, 0.2]",
        "{ from = 0.1, to = 0.2, count = 10001 }\nmesh = { from = 1, to = 1001, count = 1001 }",
    ),
    ("too long a range", "[0.1, 0.2]", "{ from = 0.1, to = 0.2, count = 4000000000 }"),
    (
        "zip of unequal lengths",
        "\"friction.mu\" = [0.1, 0.2]",
        "[[sweep.zip]]\n\"friction.mu\" = [0.1, 0.2]\nmesh = [8, 16, 32]",
    ),
    ("zip of nothing", "\"friction.mu\" = [0.1, 0.2]", "[[sweep.zip]]"),
    ("zip is a table", "\"friction.mu\" = [0.1, 0.2]", "zip = { mesh = [1, 2] }"),
    ("zip holds a number", "\"friction.mu\" = [0.1, 0.2]", "zip = [1, 2]"),
    ("punches that are texts", "\"friction.mu\" = [0.1, 0.2]", "punch = [\"sphere\"]"),
    (
        "a punch by itself",
        "\"friction.mu\" = [0.1, 0.2]",
        "punch = { shape = \"sphere\", radius = 1 }",
    ),
    (
        "punches of one name",
        "\"friction.mu\" = [0.1, 0.2]",
        "punch = [{ shape = \"sphere\", radius = 1 }, { shape = \"sphere\", radius = 2 }]",
    ),
    (
        "punch without what it needs",
        "\"friction.mu\" = [0.1, 0.2]",
        "punch = [{ shape = \"sphere\" }, { shape = \"cone\", angle = \"5 deg\" }]",
    ),
    (
        "materials without names",
        "\"friction.mu\" = [0.1, 0.2]",
        "\"foundation.base\" = [{ shear_modulus = 1, poisson = 0 }]",
    ),
    (
        "label of nothing",
        "\"friction.mu\" = [0.1, 0.2]",
        "friction = [{ label = \" \", mu = 0.3 }]",
    ),
    ("figure over nothing", "[sweep]", "[figure]\nx = \"mu\"\ny = \"stick_fracton\"\n[sweep]"),
    ("figure without y", "[sweep]", "[figure]\nx = \"mu\"\n[sweep]"),
    ("figure over words", "[sweep]", "[figure]\nx = \"shape\"\ny = \"load\"\n[sweep]"),
    (
        "figure of increments that is none",
        "[sweep]",
        "[figure]\nx = \"increment\"\ny = \"load\"\n[sweep]",
    ),
    (
        "figure of how many steps",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = \"load\"\nsteps = 3\n[sweep]",
    ),
    (
        "figure with a misspelt key",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = \"load\"\nserie = [\"mesh\"]\n[sweep]",
    ),
    ("figure that is a number", "name = ", "figure = 3\nname = "),
    (
        "figures of which one is a text",
        "name = ",
        "figure = [{ x = \"mu\", y = \"load\" }, \"load\"]\nname = ",
    ),
    (
        "figure of two units",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = [\"peak_pressure\", \"hertz_peak_pressure\", \"load\", \"mu\"]\n[sweep]",
    ),
    (
        "figure of the same column twice",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = [\"load\", \"load\"]\n[sweep]",
    ),
    ("figure of no columns", "[sweep]", "[figure]\nx = \"mu\"\ny = []\n[sweep]"),
    (
        "figure of a list with a text",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = [\"load\", \"status\", 3]\n[sweep]",
    ),
    (
        "figure over two columns",
        "[sweep]",
        "[figure]\nx = [\"mu\", \"mesh\"]\ny = \"load\"\n[sweep]",
    ),
    (
        "figure whose name is a path",
        "[sweep]",
        "[figure]\nname = \"../mu\"\nx = \"mu\"\ny = \"load\"\n[sweep]",
    ),
    (
        "figure whose name is a number",
        "[sweep]",
        "[figure]\nname = 3\ntitle = 4\nx = \"mu\"\ny = \"load\"\n[sweep]",
    ),
    (
        "figures of one name",
        "[sweep]",
        "[[figure]]\nname = \"2\"\nx = \"mu\"\ny = \"load\"\n[[figure]]\nx = \"mu\"\ny = \"energy\"\n[sweep]",
    ),
    (
        "the second of two figures without x",
        "[sweep]",
        "[[figure]]\nx = \"mu\"\ny = \"load\"\n[[figure]]\nname = \"loss\"\ny = \"energy\"\n[sweep]",
    ),
    (
        "figure with a series that is a text",
        "[sweep]",
        "[figure]\nx = \"mu\"\ny = \"load\"\nseries = \"mesh\"\n[sweep]",
    ),
    (
        "height map without a file",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nwidth_x = \"1 mm\"\nwidth_y = \"1 mm\"",
    ),
    (
        "height map that is not there",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nfile = \"gone.npy\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "ragged height map",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nfile = \"ragged.csv\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "height map in pascal",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nfile = \"ragged.csv\"\nunit = \"Pa\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "height map from nowhere",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nfile = \"\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "file and stored surface",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nfile = \"flat.csv\"\nsurface = \"00\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "stored surface that is another",
        "shape = \"sphere\"\nradius = \"10 mm\"",
        "shape = \"height-map\"\nsurface = \"flat.csv\"\nwidth_x = 1\nwidth_y = 1",
    ),
    (
        "many things at once",
        GOOD,
        "name = \"\"\n[scene.punch]\nshape = \"spere\"\nradius = \"5 MPa\"\n[numerics]\nmesh = 2.5\n[sweep]\nfriction.mu = []\n",
    ),
    ("letters beyond ASCII", "mu = 0.3", "μ = 0.3 # Reibung, größer als 0"),
];

fn files(name: &str) -> Result<NamedFile, String> {
    let named = |bytes: &[u8]| Ok(NamedFile { bytes: bytes.to_vec(), may_quote: true });
    match name {
        "flat.csv" => named(b"0 0\n0 0"),
        "ragged.csv" => named(b"1, 2\n3\n"),
        _ => Err(format!("{name}: no such file")),
    }
}

#[test]
fn every_refusal_is_clear() {
    assert!(Study::parse(GOOD, "study.toml", &mut files).is_ok());
    let mut said = String::new();
    for (name, old, new) in CASES {
        assert!(GOOD.contains(old), "{name}");
        let text = GOOD.replacen(old, new, 1);
        match Study::parse(&text, "study.toml", &mut files) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said.push_str(&format!("## {name}\n{error}\n\n")),
        }
    }
    insta::assert_snapshot!(said);
}

/// A list that is too short leaves rows without a value, which are no repetition.
#[test]
fn a_zip_of_unequal_lists_is_refused_for_their_lengths_alone() {
    let zip = "[[sweep.zip]]\nmesh = [16, 16]\ntolerance = [1e-6]\n";
    let text = GOOD.replace("[sweep]\n\"friction.mu\" = [0.1, 0.2]\n", zip);
    let error = Study::parse(&text, "study.toml", &mut files).unwrap_err();
    assert_eq!(error.mistakes().len(), 1, "{error}");
    assert!(error.to_string().contains("axes that advance together need equally many"), "{error}");
}

#[test]
fn no_two_cases_are_the_same() {
    let names: std::collections::HashSet<_> = CASES.iter().map(|(name, ..)| name).collect();
    let texts: std::collections::HashSet<_> =
        CASES.iter().map(|(_, old, new)| GOOD.replacen(old, new, 1)).collect();
    assert_eq!((names.len(), texts.len()), (CASES.len(), CASES.len()));
}

#[test]
fn positions_are_those_of_an_editor() {
    let text = GOOD
        .replace("mu = 0.3", "mu = -1 # µ")
        .replace("\"friction.mu\" = [0.1, 0.2]", "mesh = [8, 0]");
    let error = Study::parse(&text, "study.toml", &mut files).unwrap_err();
    let positions: Vec<_> =
        error.mistakes().iter().map(|mistake| error.position(mistake)).collect();
    assert_eq!(positions, [(10, 6)]);
    assert!(error.render(true).contains("\u{1b}["));
}
