//! The list itself. Each row has the name of a key in the code, its path in a study file, its
//! column and its values; the bounds of these, what it is where a study leaves it out, and an
//! example; and its meaning.

use std::f64::consts::FRAC_PI_2;

use contact::model::{Foundation, InteriorQuestion, Loading, Mesh, Numerics, Wear, WheelRail};
use contact::multiplicity::Search;
use contact::uniqueness::WitnessSearch;

use crate::bounds::{ANY, Bound, Bounds, NOT_ZERO, POSITIVE, from, inside, up_to, within};
use crate::fallback::Fallback;
use crate::quantity::Quantity;
use crate::units::Dimension;

macro_rules! keys {
    ($(
        $name:ident $(($index:ident: $type:ty))?, $path:literal, $column:literal, $quantity:expr,
        $bounds:expr, $fallback:expr, $example:literal,
        $meaning:literal;
    )*) => {
        /// A key of a scene or of its numerics; the key of a layer or a step carries the index of
        /// it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Key {
            $(#[doc = $meaning] $name $(($type))?,)*
        }

        impl Key {
            /// Every key, in the order of the scene's and the numerics' fields; keys of lists have
            /// index 0.
            pub(crate) const ALL: &'static [Key] = &[$(Key::$name $((<$type>::MIN))?),*];

            /// Returns the key of another layer or step.
            pub(crate) fn with_index(self, index: u32) -> Key {
                match self {
                    $(Key::$name { .. } => Key::$name $(({
                        let $index: $type = index;
                        $index
                    }))?,)*
                }
            }

            /// Returns the index of its layer or step.
            pub(crate) fn index(self) -> Option<u32> {
                match self { $(Key::$name $(($index))? => None $(.or(Some($index)))?,)* }
            }

            /// Returns its path in a study file, with `i` for an index.
            pub(crate) fn pattern(self) -> &'static str {
                match self { $(Key::$name { .. } => $path,)* }
            }

            pub(crate) fn column_pattern(self) -> &'static str {
                match self { $(Key::$name { .. } => $column,)* }
            }

            /// Returns the values that may stand behind it.
            pub(crate) fn quantity(self) -> Quantity {
                match self { $(Key::$name { .. } => $quantity,)* }
            }

            /// Returns the bounds of the values that have a meaning; of a list, those of the number
            /// of its entries.
            pub(crate) fn bounds(self) -> Bounds {
                match self { $(Key::$name { .. } => $bounds,)* }
            }

            /// Returns what it is where a study leaves it out.
            pub(crate) fn fallback(self) -> Fallback {
                match self { $(Key::$name { .. } => $fallback,)* }
            }

            /// Returns a value as a study file may have it.
            pub(crate) fn example(self) -> &'static str {
                match self { $(Key::$name { .. } => $example,)* }
            }

            /// Returns its meaning in words.
            pub(crate) fn meaning(self) -> &'static str {
                match self { $(Key::$name { .. } => $meaning,)* }
            }
        }
    };
}

use Dimension::{
    Angle, AnglePerLength, AngularVelocity, Force, Length, Moment, PerPressure, Pressure, Pure,
    Velocity,
};
use Fallback::{ByKind, Empty, Follows, Needed, Word};
use Quantity::{Choice, Count, Effects, Flag, LengthUnit, Lengths, List, Number, Places, Text};

/// Examples of a layer and a load step.
const LAYER: &str = "{ youngs_modulus = \"210 GPa\", poisson = 0.3, thickness = \"0.5 mm\" }";
const STEP: &str = "{ approach = \"1 um\" }";

/// The words for keys that are left out, where no value stands in their place.
const BY_YOUNG: &str = "follows from `youngs_modulus`, and one of the two must be given";
const BY_SHEAR: &str = "follows from `shear_modulus`, and one of the two must be given";
const AS_BEFORE: &str = "as before the step";
const AS_BEFORE_OR_FORCE: &str = "as before the step; the first step needs one of the two";

keys! {
    Layers, "scene.foundation.layers", "layers", List(LAYER),
        up_to(Foundation::MAX_LAYERS as f64), Empty,
        "[{ youngs_modulus = \"20 GPa\", poisson = 0.35, thickness = \"10 um\" }]",
        "number of layers of the foundation";
    LayerShearModulus(i: u32), "scene.foundation.layers[i].shear_modulus", "layer[i]_shear_modulus",
        Number(Pressure),
        POSITIVE, Follows(BY_YOUNG), "\"7.4 GPa\"",
        "shear modulus G of a layer";
    LayerYoungsModulus(i: u32), "scene.foundation.layers[i].youngs_modulus",
        "layer[i]_youngs_modulus", Number(Pressure),
        POSITIVE, Follows(BY_SHEAR), "\"20 GPa\"",
        "Young's modulus E of a layer";
    LayerPoisson(i: u32), "scene.foundation.layers[i].poisson", "layer[i]_poisson", Number(Pure),
        within(0.0, 0.5), Needed, "0.35",
        "Poisson's ratio ν of a layer";
    LayerThickness(i: u32), "scene.foundation.layers[i].thickness", "layer[i]_thickness",
        Number(Length),
        POSITIVE, Needed, "\"10 um\"",
        "thickness of a layer";
    Base, "scene.foundation.base", "base", Choice(&["rigid"]),
        ANY, Follows("an elastic base, whose constants are given"), "\"rigid\"",
        "what the layers rest on, if it is not elastic";
    ShearModulus, "scene.foundation.base.shear_modulus", "shear_modulus", Number(Pressure),
        POSITIVE, Follows(BY_YOUNG), "\"80 GPa\"",
        "shear modulus G of the foundation's base";
    YoungsModulus, "scene.foundation.base.youngs_modulus", "youngs_modulus", Number(Pressure),
        POSITIVE, Follows(BY_SHEAR), "\"210 GPa\"",
        "Young's modulus E of the foundation's base";
    Poisson, "scene.foundation.base.poisson", "poisson", Number(Pure),
        within(0.0, 0.5), Needed, "0.3",
        "Poisson's ratio ν of the foundation's base";
    Shape, "scene.punch.shape", "shape",
        Choice(&[
            "sphere", "ellipsoid", "flat-rectangle", "flat-disk", "cone", "height-map",
            "wheel-on-rail",
        ]),
        ANY, Needed, "\"sphere\"",
        "shape of the punch";
    Radius, "scene.punch.radius", "radius", Number(Length),
        POSITIVE, Needed, "\"5 mm\"",
        "radius of a sphere or a flat disk";
    RadiusX, "scene.punch.radius_x", "radius_x", Number(Length),
        POSITIVE, Needed, "\"5 mm\"",
        "radius of curvature of an ellipsoid in the x–z plane";
    RadiusY, "scene.punch.radius_y", "radius_y", Number(Length),
        POSITIVE, Needed, "\"20 mm\"",
        "radius of curvature of an ellipsoid in the y–z plane";
    WidthX, "scene.punch.width_x", "width_x", Number(Length),
        POSITIVE, Follows("of a height map as its file states"), "\"2 mm\"",
        "extent of the punch along x";
    WidthY, "scene.punch.width_y", "width_y", Number(Length),
        POSITIVE, Follows("of a height map as its file states"), "\"1 mm\"",
        "extent of the punch along y";
    ConeAngle, "scene.punch.angle", "angle", Number(Angle),
        Bounds { upper: Bound::Open(FRAC_PI_2), ..POSITIVE }, Needed, "\"5 deg\"",
        "angle between a cone and the plane of contact";
    File, "scene.punch.file", "file", Text,
        ANY, Needed, "\"heights.csv\"",
        "file with the heights of a height map: NPY, or a matrix or a list of x, y and z as text";
    HeightUnit, "scene.punch.unit", "unit", LengthUnit,
        ANY, Follows("that of the file's header, else m"), "\"um\"",
        "unit of the heights in the file, that of its header or m unless given";
    LateralUnit, "scene.punch.lateral_unit", "lateral_unit", LengthUnit,
        ANY, Follows("that of the file's header, else that of the heights"), "\"mm\"",
        "unit of x and y in the file, that of its header or of the heights unless given";
    Missing, "scene.punch.missing", "missing", Choice(&["fill", "exclude", "none"]),
        ANY, Follows("missing pixels are refused where there are some"), "\"fill\"",
        "what becomes of missing pixels: they are filled from their neighbours, they are no part \
         of the sole, or there are none";
    MissingValue, "scene.punch.missing_value", "missing_value", Number(Pure),
        ANY, Follows("that which the file's form or header marks"), "-9999",
        "height in the file, in its unit, that marks a missing pixel";
    Surface, "scene.punch.surface", "surface", Text,
        ANY, Follows("the heights of `file`"), "\"0f…\"",
        "name of a stored surface, the hash of its heights";
    Wheel, "scene.punch.wheel", "wheel", Text,
        ANY, Needed, "\"profiles/wheel.prw\"",
        "file with the wheel's profile, of SIMPACK, of MiniProf or a list; in a stored job, its \
         hash";
    Rail, "scene.punch.rail", "rail", Text,
        ANY, Needed, "\"profiles/rail.prr\"",
        "file with the rail's profile, of SIMPACK, of MiniProf or a list; in a stored job, its \
         hash";
    Side, "scene.punch.side", "side", Choice(&["left", "right"]),
        ANY, Needed, "\"right\"",
        "which wheel of the wheelset";
    RollingRadius, "scene.punch.rolling_radius", "rolling_radius", Number(Length),
        POSITIVE, Needed, "\"460 mm\"",
        "radius of the wheel at its profile's z = 0";
    Gauge, "scene.punch.gauge", "gauge", Number(Length),
        POSITIVE, Fallback::Number(WheelRail::GAUGE), "\"1.432 m\"",
        "distance between the rails' gauge faces";
    GaugeDepth, "scene.punch.gauge_depth", "gauge_depth", Number(Length),
        ANY, Fallback::Number(WheelRail::GAUGE_DEPTH), "\"16 mm\"",
        "depth below the rails' tops at which the gauge is measured";
    FlangeBackDistance, "scene.punch.flange_back_distance", "flange_back_distance", Number(Length),
        POSITIVE, Fallback::Number(WheelRail::FLANGE_BACK_DISTANCE), "\"1.363 m\"",
        "distance between the backs of the flanges";
    FlangeBackToOrigin, "scene.punch.flange_back_to_origin", "flange_back_to_origin",
        Number(Length),
        ANY, Fallback::Number(WheelRail::FLANGE_BACK_TO_ORIGIN), "\"72 mm\"",
        "from the back of a flange to its profile's y = 0";
    Lateral, "scene.punch.lateral", "lateral", Number(Length),
        ANY, Fallback::Number(0.0), "\"2 mm\"",
        "lateral displacement of the wheelset, positive to the right";
    Yaw, "scene.punch.yaw", "yaw", Number(Angle),
        ANY, Fallback::Number(0.0), "\"3 mrad\"",
        "yaw of the wheelset about z, positive turns x towards y";
    Roll, "scene.punch.roll", "roll", Number(Angle),
        ANY, Fallback::Number(0.0), "\"-0.1 mrad\"",
        "roll of the wheelset about x, positive lowers the right wheel";
    Speed, "scene.punch.speed", "speed", Number(Velocity),
        NOT_ZERO, Follows("no motion: steps that roll give their creepages"), "\"20 m/s\"",
        "velocity of the wheelset along the track; steps that roll then take their creepages from \
         its motion";
    AngularSpeed, "scene.punch.angular_speed", "angular_speed", Number(AngularVelocity),
        ANY, Follows("`speed` over `rolling_radius`"), "\"43.5 rad/s\"",
        "angular speed of the wheelset about its axle, speed over rolling_radius unless given";
    LateralVelocity, "scene.punch.lateral_velocity", "lateral_velocity", Number(Velocity),
        ANY, Fallback::Number(0.0), "\"10 mm/s\"",
        "velocity of the wheelset along y, positive to the right";
    YawRate, "scene.punch.yaw_rate", "yaw_rate", Number(AngularVelocity),
        ANY, Fallback::Number(0.0), "\"50 mrad/s\"",
        "rate of the wheelset's yaw, against rails that rest";
    RollRate, "scene.punch.roll_rate", "roll_rate", Number(AngularVelocity),
        ANY, Fallback::Number(0.0), "\"1 mrad/s\"",
        "rate of the wheelset's roll";
    PunchShearModulus, "scene.punch.material.shear_modulus", "punch_shear_modulus",
        Number(Pressure),
        POSITIVE, Follows("that of `youngs_modulus`; a punch without material is rigid"),
        "\"80 GPa\"",
        "shear modulus G of an elastic punch";
    PunchYoungsModulus, "scene.punch.material.youngs_modulus", "punch_youngs_modulus",
        Number(Pressure),
        POSITIVE, Follows("that of `shear_modulus`; a punch without material is rigid"),
        "\"210 GPa\"",
        "Young's modulus E of an elastic punch";
    PunchPoisson, "scene.punch.material.poisson", "punch_poisson", Number(Pure),
        within(0.0, 0.5), Follows("needed beside a modulus; a punch without material is rigid"),
        "0.3",
        "Poisson's ratio ν of an elastic punch";
    Mu, "scene.friction.mu", "mu", Number(Pure),
        from(0.0), Fallback::Number(0.0), "0.3",
        "coefficient of friction μ";
    WearCoefficient, "scene.wear.coefficient", "wear_coefficient", Number(PerPressure),
        from(0.0), Needed, "\"1e-8 1/MPa\"",
        "wear coefficient k of both surfaces together: depth over pressure and sliding distance";
    WearUpdate, "scene.wear.update", "wear_update", Flag,
        ANY, Fallback::Flag(false), "true",
        "whether each increment meets the shape that the wear before it has left";
    WearRepeat, "scene.wear.repeat", "wear_repeat", Count,
        within(1.0, Wear::MAX_CYCLES as f64), Fallback::Count(1), "1000",
        "cycles that each cycle of the path stands for: it wears so many times as much";
    DomainWidthX, "scene.domain.width_x", "domain_width_x", Number(Length),
        POSITIVE, Needed, "\"0.5 mm\"",
        "extent of Ω along x";
    DomainWidthY, "scene.domain.width_y", "domain_width_y", Number(Length),
        POSITIVE, Needed, "\"0.5 mm\"",
        "extent of Ω along y";
    DomainCenterX, "scene.domain.center_x", "domain_center_x", Number(Length),
        ANY, Fallback::Number(0.0), "\"0.1 mm\"",
        "x of the centre of Ω";
    DomainCenterY, "scene.domain.center_y", "domain_center_y", Number(Length),
        ANY, Fallback::Number(0.0), "\"-0.1 mm\"",
        "y of the centre of Ω";
    Steps, "scene.loading.steps", "steps", List(STEP),
        within(1.0, Loading::MAX_INCREMENTS as f64), Needed,
        "[{ approach = \"1 um\" }, { shift_x = \"0.5 um\" }]",
        "number of load steps";
    Approach(i: u32), "scene.loading.steps[i].approach", "step[i]_approach", Number(Length),
        ANY, Follows(AS_BEFORE_OR_FORCE), "\"1 um\"",
        "approach δ of the punch, positive into the foundation";
    NormalForce(i: u32), "scene.loading.steps[i].normal_force", "step[i]_normal_force",
        Number(Force),
        POSITIVE, Follows(AS_BEFORE_OR_FORCE), "\"10 N\"",
        "normal force that is prescribed instead of the approach";
    ShiftX(i: u32), "scene.loading.steps[i].shift_x", "step[i]_shift_x", Number(Length),
        ANY, Follows(AS_BEFORE), "\"0.5 um\"",
        "shift of the punch along x";
    ForceX(i: u32), "scene.loading.steps[i].force_x", "step[i]_force_x", Number(Force),
        ANY, Follows(AS_BEFORE), "\"1 N\"",
        "tangential force along x that is prescribed instead of the shift";
    ShiftY(i: u32), "scene.loading.steps[i].shift_y", "step[i]_shift_y", Number(Length),
        ANY, Follows(AS_BEFORE), "\"0.5 um\"",
        "shift of the punch along y";
    ForceY(i: u32), "scene.loading.steps[i].force_y", "step[i]_force_y", Number(Force),
        ANY, Follows(AS_BEFORE), "\"1 N\"",
        "tangential force along y that is prescribed instead of the shift";
    TiltX(i: u32), "scene.loading.steps[i].tilt_x", "step[i]_tilt_x", Number(Angle),
        ANY, Follows(AS_BEFORE), "\"0.1 mrad\"",
        "tilt of the punch about the x axis";
    MomentX(i: u32), "scene.loading.steps[i].moment_x", "step[i]_moment_x", Number(Moment),
        ANY, Follows(AS_BEFORE), "\"1 N mm\"",
        "moment about x that is prescribed instead of the tilt";
    TiltY(i: u32), "scene.loading.steps[i].tilt_y", "step[i]_tilt_y", Number(Angle),
        ANY, Follows(AS_BEFORE), "\"0.1 mrad\"",
        "tilt of the punch about the y axis";
    MomentY(i: u32), "scene.loading.steps[i].moment_y", "step[i]_moment_y", Number(Moment),
        ANY, Follows(AS_BEFORE), "\"1 N mm\"",
        "moment about y that is prescribed instead of the tilt";
    Twist(i: u32), "scene.loading.steps[i].twist", "step[i]_twist", Number(Angle),
        ANY, Follows(AS_BEFORE), "\"0.1 mrad\"",
        "twist of the punch about the z axis";
    MomentZ(i: u32), "scene.loading.steps[i].moment_z", "step[i]_moment_z", Number(Moment),
        ANY, Follows(AS_BEFORE), "\"1 N mm\"",
        "moment about z that is prescribed instead of the twist";
    Increments(i: u32), "scene.loading.steps[i].increments", "step[i]_increments", Count,
        within(1.0, Loading::MAX_INCREMENTS as f64),
        Follows("1; of a `distance` as `dq` or the elements divide it"), "10",
        "equal parts in which the step is taken";
    CreepageX(i: u32), "scene.loading.steps[i].creepage_x", "step[i]_creepage_x", Number(Pure),
        ANY, Follows(AS_BEFORE), "0.001",
        "longitudinal creepage ξ of a step that rolls, of the foundation against the punch";
    CreepageY(i: u32), "scene.loading.steps[i].creepage_y", "step[i]_creepage_y", Number(Pure),
        ANY, Follows(AS_BEFORE), "0.0005",
        "lateral creepage η of a step that rolls, of the foundation against the punch";
    Spin(i: u32), "scene.loading.steps[i].spin", "step[i]_spin", Number(AnglePerLength),
        ANY, Follows(AS_BEFORE), "\"0.1 rad/m\"",
        "spin φ of a step that rolls, of the foundation against the punch";
    SpinCenter(i: u32), "scene.loading.steps[i].spin_center", "step[i]_spin_center", Number(Length),
        ANY, Fallback::Number(0.0), "\"0.1 mm\"",
        "x about which the spin turns";
    Direction(i: u32), "scene.loading.steps[i].direction", "step[i]_direction",
        Choice(&["forward", "backward"]),
        ANY, Word("forward"), "\"backward\"",
        "way that a contact rolls, towards +x or −x";
    Distance(i: u32), "scene.loading.steps[i].distance", "step[i]_distance", Number(Length),
        POSITIVE, Follows("the step is steady, or does not roll"), "\"1 mm\"",
        "distance that a step rolls from the state before it";
    Dq(i: u32), "scene.loading.steps[i].dq", "step[i]_dq", Number(Length),
        POSITIVE, Follows("the length of an element along x"), "\"0.1 mm\"",
        "distance that the contact rolls in an increment; beside a distance the longest one, while \
         `increment_distance` is what an increment has rolled";
    Steady(i: u32), "scene.loading.steps[i].steady", "step[i]_steady", Flag,
        ANY, Fallback::Flag(false), "true",
        "whether a step is the steady state of rolling";
    CycleFrom, "scene.loading.cycle_from", "cycle_from", Count,
        ANY, Follows("no step is repeated"), "0",
        "index of the step with which a cycle begins";
    Cycles, "scene.loading.cycles", "cycles", Count,
        within(1.0, Loading::MAX_INCREMENTS as f64), Fallback::Count(1), "3",
        "how often the cycle is run through";
    InteriorMaximum, "interior.maximum", "interior_maximum", Flag,
        ANY, Fallback::Flag(false), "true",
        "whether the largest von Mises and Tresca stresses below the surface are sought";
    InteriorDepth, "interior.depth", "interior_depth", Number(Length),
        from(0.0), Follows("no plane, or those of `depths`"), "\"0.1 mm\"",
        "depth of a plane below the surface on which stresses are computed";
    InteriorDepths, "interior.depths", "interior_depths", Lengths,
        up_to(InteriorQuestion::MOST_DEPTHS as f64), Empty, "[\"0.1 mm\", \"0.3 mm\"]",
        "depths of planes below the surface on which stresses are computed";
    InteriorPoints, "interior.points", "interior_points", Places,
        up_to(InteriorQuestion::MOST_POINTS as f64), Empty, "[[0, 0, \"0.1 mm\"]]",
        "points below the surface at which the stress is computed";
    Mesh, "numerics.mesh", "mesh", Quantity::Mesh,
        within(1.0, Mesh::MAX_SIDE as f64), Needed, "64",
        "elements across Ω";
    Projection, "numerics.projection", "projection", Choice(&["average", "midpoint"]),
        ANY, Word("average"), "\"midpoint\"",
        "how the continuous operator becomes a matrix";
    Epsilon, "numerics.epsilon", "epsilon", Number(Pure),
        from(0.0), Fallback::Number(0.0), "0.001",
        "regularisation ε of equation (3)";
    Ceiling, "numerics.ceiling", "ceiling", Number(Pressure),
        POSITIVE, Follows("no ceiling"), "\"1 GPa\"",
        "a-priori ceiling u on the pressure in equation (3)";
    Method, "numerics.method", "method", Choice(&["auto", "newton", "seidel"]),
        ANY, Word("auto"), "\"newton\"",
        "solver";
    Tolerance, "numerics.tolerance", "tolerance", Number(Pure),
        inside(0.0, 1.0), Fallback::Number(Numerics::default_tolerance()), "1e-10",
        "largest relative residual that counts as solved";
    MaxIterations, "numerics.max_iterations", "max_iterations", Count,
        from(1.0), Fallback::Count(Numerics::default_max_iterations()), "50000",
        "iterations after which the solver gives up";
    Simulate, "numerics.simulate", "simulate", Effects,
        ANY, Empty, "[\"coupling\"]",
        "effects that are simulated although the scene does not call for them";
    Starts, "search.starts", "starts", Count,
        up_to(Search::MOST_STARTS as f64), ByKind(&[("multiplicity", 60), ("uniqueness", 24)]),
        "200",
        "random starts of a search";
    Seed, "search.seed", "seed", Count,
        ANY, ByKind(&[("multiplicity", 0), ("uniqueness", 1)]), "7",
        "seed of the random starts";
    Cases, "search.cases", "cases", Flag,
        ANY, Fallback::Flag(false), "true",
        "whether the lower end of μ* is shown by cases of open and closed elements, of which there \
         are up to 16: nearer to the upper end, and longer to find";
    Width, "search.width", "width", Number(Pure),
        within(WitnessSearch::WIDTHS[0], WitnessSearch::WIDTHS[1]),
        Follows("what the cases alone show"), "0.02",
        "relative width that a bracket by `cases` is to have: the fields of its cases are cut into \
         cones for it; where that takes too many, it is content with twice the width, and so on";
    Plane, "search.plane", "plane", Flag,
        ANY, Fallback::Flag(false), "true",
        "whether tractions lie in the plane of x and z, on one row of elements whose μ* is then \
         exact";
}
