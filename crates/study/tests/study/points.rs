//! The points of a study beyond the product of its axes: what is left out.

use study::{NamedFile, Study, StudyError, Value};

/// A study of two axes, beside which the tests write.
const GOOD: &str = r#"name = "good"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 16
[sweep]
"friction.mu" = [0.1, 0.2, 0.3]
"punch.radius" = ["5 mm", "10 mm"]
"#;

/// The name of each case, and what it adds to the study.
const EXCLUSIONS: &[(&str, &str)] = &[
    ("no list of tables", "[exclude]\nwhen = \"mu > 0.2\"\n"),
    ("no condition", "[[exclude]]\n"),
    ("misspelt when", "[[exclude]]\nwhn = \"mu > 0.2\"\n"),
    ("a condition that is a number", "[[keep]]\nwhen = 3\n"),
    ("an empty condition", "[[keep]]\nwhen = \" \"\n"),
    ("a result", "[[exclude]]\nwhen = \"peak_pressure > 1e9\"\n"),
    ("the status", "[[keep]]\nwhen = \"status == 'certified'\"\n"),
    ("a misspelt axis", "[[exclude]]\nwhen = \"radus > 0.007\"\n"),
    ("a key that is not given", "[[exclude]]\nwhen = \"epsilon > 0\"\n"),
    ("the other modulus", "[[exclude]]\nwhen = \"youngs_modulus > 1e9\"\n"),
    ("no grammar", "[[exclude]]\nwhen = \"mu > 0.2 and radius > 0.007\"\n"),
    ("a number and a text", "[[exclude]]\nwhen = \"mu == 'high'\"\n"),
    ("a number alone", "[[exclude]]\nwhen = \"mu\"\n"),
    ("a unit", "[[exclude]]\nwhen = \"radius > 7 mm\"\n"),
    ("nothing left", "[[exclude]]\nwhen = \"mu > 0\"\n"),
    ("nothing kept", "[[keep]]\nwhen = \"radius > 7\"\n"),
    (
        "the axis that is halved",
        "[[exclude]]\nwhen = \"mu > 0.25\"\n[bisect]\naxis = \"mu\"\non = \"load > 0\"\nto = \"1%\"\n",
    ),
    (
        "the mesh that is refined",
        "[[exclude]]\nwhen = \"mesh > 25\"\n[refine]\non = \"load\"\nuntil = \"1%\"\n",
    ),
    (
        "the rungs of a ladder",
        "mesh = [8, 16, 32]\n[convergence]\n[[exclude]]\nwhen = \"mesh < 10\"\n",
    ),
    ("the rungs of costs", "mesh = [8, 16, 32]\n[cost]\n[[keep]]\nwhen = \"mesh * mu > 2\"\n"),
];

/// The name of each case, and what it adds to the study.
const DERIVATIONS: &[(&str, &str)] = &[
    ("no table", "[[derive]]\nmesh = \"3\"\n"),
    ("a number", "[derive]\ntolerance = 1e-8\n"),
    ("no formula", "[derive]\ntolerance = \"\"\n"),
    ("an unknown key", "[derive]\n\"numerics.tolerence\" = \"1e-8\"\n"),
    ("an unknown name", "[derive]\ntolerance = \"1e-8 * raduis / 1 m\"\n"),
    ("a key that is not given", "[derive]\ntolerance = \"1e-8 + epsilon\"\n"),
    ("a result", "[derive]\ntolerance = \"1e-8 * peak_pressure\"\n"),
    ("a text key", "[derive]\nmethod = \"radius\"\n"),
    ("a formula of a text", "[derive]\ntolerance = \"shape * 2\"\n"),
    ("given by the scene", "[derive]\n\"loading.steps[0].approach\" = \"radius / 1e4\"\n"),
    ("given by an axis", "[derive]\nfriction.mu = \"radius / 1 m\"\n"),
    ("the other modulus", "[derive]\nfoundation.base.youngs_modulus = \"1 GPa\"\n"),
    ("no such layer", "[derive]\n\"foundation.layers[0].thickness\" = \"0.1 * radius\"\n"),
    ("no such step", "[derive]\n\"loading.steps[1].shift_x\" = \"0.1 * radius\"\n"),
    ("a length for a pure number", "[derive]\ntolerance = \"1e-8 * radius\"\n"),
    ("a pure number for a pressure", "[derive]\nceiling = \"3 * mu\"\n"),
    ("a sum of a length and a number", "[derive]\ntolerance = \"(radius + 1) / 1 m\"\n"),
    ("an unknown unit", "[derive]\ntolerance = \"radius / 2 furlong\"\n"),
    ("an unknown function", "[derive]\ntolerance = \"log(mu)\"\n"),
    ("a sign too many", "[derive]\ntolerance = \"1e-8 ** mu\"\n"),
    ("an open parenthesis", "[derive]\ntolerance = \"1e-8 * (mu + 1\"\n"),
    ("nothing after a sign", "[derive]\ntolerance = \"1e-8 *\"\n"),
    ("itself", "[derive]\ntolerance = \"tolerance / 2\"\n"),
    (
        "a circle",
        "[derive]\ntolerance = \"epsilon + 1e-8\"\nepsilon = \"1e-9 * max_iterations\"\n\
         max_iterations = \"round(1 / tolerance)\"\n",
    ),
    ("twice", "[derive]\ntolerance = \"1e-8\"\nnumerics.tolerance = \"1e-8\"\n"),
    ("a part of an element", "[derive]\nmax_iterations = \"1000 * mu + 0.5\"\n"),
    ("a division by 0", "[derive]\nepsilon = \"1e-9 / (mu - 0.2)\"\n"),
    ("a division by 0 at a later value", "[derive]\nepsilon = \"1e-9 / (mu - 0.3)\"\n"),
    ("a mesh that is refined", "[derive]\nmesh = \"8\"\n[refine]\non = \"load\"\nuntil = \"1%\"\n"),
    ("a mesh of an accuracy", "[derive]\nmesh = \"8\"\n[accuracy]\nis = \"1%\"\n"),
    ("a value out of bounds", "[derive]\ntolerance = \"mu - 0.2\"\n"),
];

/// The name of each case, and a file of points that is none.
const FILES: &[(&str, &str)] = &[
    ("nothing", ""),
    ("heads alone", "mesh,tolerance\n"),
    ("a misspelt head", "mesh,tolerence\n16,1e-8\n"),
    ("an unknown head", "mesh,temperature\n16,300\n"),
    ("no head", "mesh,\n16,1e-8\n"),
    ("results alone", "load,status\n1,certified\n"),
    ("a table", "mesh,punch\n16,sphere\n"),
    ("a list", "mesh,loading.steps\n16,1\n"),
    ("a head twice", "mesh,numerics.mesh\n16,16\n"),
    ("a unit of something else", "mesh,ceiling [mm]\n16,3\n"),
    ("an unknown unit", "mesh,ceiling [atm]\n16,3\n"),
    ("a unit of a pure number", "mesh,tolerance [m]\n16,1e-8\n"),
    ("ragged lines", "mesh,tolerance\n16\n\n16,1e-8,3\n# comment\n32\n"),
    (
        "all kinds of values",
        "mesh,method,max_iterations,ceiling\n2.5,guess,-3,5 mm\n,,,\nx,newton,1,inf\n",
    ),
    ("units twice", "mesh,ceiling [MPa]\n16,5 MPa\n16,1e400\n"),
    ("an axis as well", "mesh,mu\n16,0.3\n"),
    ("no scene", "mesh,tolerance\n16,1e-8\n0,2\n"),
    ("a binary file", "\u{1}\u{2}"),
];

fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut no_files)
}

fn with(addition: &str) -> Study {
    read(&format!("{GOOD}{addition}")).unwrap_or_else(|error| panic!("{addition}{error}"))
}

/// Returns the values of the points of a study, as text.
fn values(study: &Study) -> Vec<String> {
    let row = |point: study::StudyPoint| {
        point.values.iter().map(Value::to_string).collect::<Vec<_>>().join(" ")
    };
    study.points().into_iter().map(row).collect()
}

/// Returns what is said of studies that each case spoils.
fn refusals(cases: &[(&str, &str)]) -> String {
    let mut said = String::new();
    for (name, addition) in cases {
        let mut text = format!("{GOOD}{addition}");
        for kind in ["convergence", "cost"] {
            if addition.contains(&format!("[{kind}]")) {
                text = format!("kind = \"{kind}\"\n{text}");
            }
        }
        if addition.contains("\nmesh = \"8\"") {
            text = text.replace("mesh = 16\n", "");
        }
        match read(&text) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said += &format!("## {name}\n{error}\n\n"),
        }
    }
    said
}

#[test]
fn conditions_without_meaning_are_refused_at_their_place() {
    insta::assert_snapshot!(refusals(EXCLUSIONS));
}

#[test]
fn formulas_without_meaning_are_refused_at_their_place() {
    insta::assert_snapshot!(refusals(DERIVATIONS));
}

#[test]
fn derived_keys_are_those_of_the_jobs() {
    let scene =
        "loading.steps = [{ approach = \"1 um\" }]\nfoundation.layers = [{ poisson = 0.3 }]";
    let good = GOOD.replace("loading.steps = [{ approach = \"1 um\" }]", scene);
    assert_ne!(good, GOOD);
    let derived = format!(
        "{good}[derive]\n\"foundation.layers[0].shear_modulus\" = \"0.1 * shear_modulus\"\n\
         foundation.layers[0].thickness = \"punch.radius * domain.width_x / 2 cm\"\n\
         domain.width_x = \"1 mm + 0.1 * radius\"\ndomain.width_y = \"domain_width_x\"\n\
         numerics.mesh = \"ceil(radius / 0.3 mm)\"\n"
    )
    .replace("foundation.layers[0].thickness", "\"foundation.layers[0].thickness\"")
    .replace("mesh = 16\n", "");
    let study = read(&derived).unwrap_or_else(|error| panic!("{error}"));
    let given = |width: &str, thickness: &str, modulus: &str, mesh: u32, radius: &str, mu: f64| {
        let text = GOOD
            .replace(
                "loading.steps",
                &format!(
                    "domain = {{ width_x = \"{width}\", width_y = \"{width}\" }}\n\
                     foundation.layers = [{{ poisson = 0.3, shear_modulus = \"{modulus}\", \
                     thickness = \"{thickness}\" }}]\nloading.steps"
                ),
            )
            .replace("mesh = 16", &format!("mesh = {mesh}"))
            .replace("[\"5 mm\", \"10 mm\"]", &format!("[\"{radius}\"]"))
            .replace("[0.1, 0.2, 0.3]", &format!("[{mu}]"));
        read(&text).unwrap_or_else(|error| panic!("{error}")).points()[0].key
    };
    let points = study.points();
    assert_eq!(points.len(), 6);
    assert_eq!(points[2].key, given("1.5 mm", "0.375 mm", "8 GPa", 17, "5 mm", 0.2));
    assert_eq!(points[5].key, given("2 mm", "1 mm", "8 GPa", 34, "10 mm", 0.3));
    // They are columns, and names of conditions.
    let columns = study.columns();
    let column = study::columns::find(&columns, "layer0_thickness").unwrap();
    assert_eq!(column.value(&points[5], None), Value::Number(1e-3));
    let kept = read(&format!("{derived}[[keep]]\nwhen = \"layer0_thickness < 0.0005\"\n"));
    assert_eq!(kept.unwrap().excluded(), 3);
}

/// What a study chooses at a point changes what follows from it.
#[test]
fn derived_keys_follow_values_that_a_study_chooses() {
    let text = GOOD.replace("[{ approach = \"1 um\" }]", "[{}]").replace(
        "[sweep]",
        "[derive]\n\"loading.steps[0].approach\" = \"mu * 10 um\"\nepsilon = \"1e-9 * mesh\"\n[sweep]",
    );
    let study = read(&text).unwrap_or_else(|error| panic!("{error}"));
    let columns = study.columns();
    let at = |point: &study::StudyPoint, name: &str| {
        study::columns::find(&columns, name).unwrap().value(point, None)
    };
    let between = study.point_at(0, &[(0, 0.15)]).unwrap();
    assert_eq!(at(&between, "approach"), Value::Number(1.5e-6));
    let finer = study.point_on_mesh(0, contact::model::Mesh::Across(32)).unwrap();
    assert_eq!(at(&finer, "epsilon"), Value::Number(3.2e-8));
}

/// A layer that a point does not have has no thickness.
#[test]
fn keys_of_absent_entries_are_not_derived() {
    let text = GOOD.replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]",
        "foundation.layers = [[], [{ shear_modulus = \"1 GPa\", poisson = 0.3 }]]",
    );
    let text = format!("{text}[derive]\n\"foundation.layers[0].thickness\" = \"radius / 100\"\n");
    let study = read(&text).unwrap_or_else(|error| panic!("{error}"));
    let columns = study.columns();
    let column = study::columns::find(&columns, "layer0_thickness").unwrap();
    let points = study.points();
    assert_eq!(column.value(&points[0], None), Value::Missing);
    assert_eq!(column.value(&points[1], None), Value::Number(1e-4));
}

/// A layer that axes make has all of its keys.
#[test]
fn keys_of_entries_that_axes_make_are_derived() {
    let text = GOOD.replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]",
        "\"foundation.layers[0].thickness\" = [\"1 mm\", \"2 mm\"]",
    );
    let derive = "[derive]\n\"foundation.layers[0].shear_modulus\" = \"shear_modulus / 10\"\n\
                  \"foundation.layers[0].poisson\" = \"poisson\"\n";
    let study = read(&format!("{text}{derive}")).unwrap_or_else(|error| panic!("{error}"));
    let columns = study.columns();
    let column = study::columns::find(&columns, "layer0_shear_modulus").unwrap();
    assert!(study.points().iter().all(|point| column.value(point, None) == Value::Number(8e9)));
    let beyond = derive.replace("layers[0].poisson", "layers[1].poisson");
    let said = read(&format!("{text}{beyond}")).unwrap_err().to_string();
    assert!(said.contains("there is no `foundation.layers[1].poisson`"), "{said}");
}

/// A key that is set is no longer derived.
#[test]
fn a_setting_takes_the_place_of_a_formula() {
    let text = format!("{GOOD}[derive]\ntolerance = \"1e-8 * mu\"\n");
    let set = ["tolerance=1e-6".to_owned()];
    let edited = study::edit::with_settings(&text, "study.toml", &set, &mut no_files).unwrap();
    assert!(!edited.contains("1e-8 * mu"), "{edited}");
    assert!(read(&edited).is_ok());
}

/// Returns a study whose file of points has this text, with an addition to `[points]`.
fn with_points(table: &str, text: &str) -> Result<Study, StudyError> {
    let mut files = |_: &str| Ok(NamedFile { bytes: text.as_bytes().to_vec(), may_quote: true });
    let study =
        GOOD.replace("[sweep]", &format!("[points]\nfile = \"points.csv\"\n{table}[sweep]"));
    Study::parse(&study.replace("mesh = 16\n", ""), "study.toml", &mut files)
}

#[test]
fn files_of_points_without_meaning_are_refused_with_all_their_faults() {
    let mut said = String::new();
    for (name, text) in FILES {
        match with_points("", text) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said += &format!("## {name}\n{error}\n\n"),
        }
    }
    for table in
        ["file = 3\n", "columns = []\n", "columns = [\"mesh\", \"epsilon\"]\n", "colums = []\n"]
    {
        let error = with_points(table, "mesh,tolerance\n16,1e-8\n").unwrap_err();
        said += &format!("## {table}{error}\n\n");
    }
    insta::assert_snapshot!(said);
}

#[test]
fn files_give_points_with_units_of_heads_and_of_values() {
    let text = "\u{feff}numerics.mesh; tolerance [1] ;ceiling [MPa];epsilon;status\r\n\
                # measured on Monday\r\n16;1e-8;2.5e3;0;failed\r\n\r\n\"8x4\";1e-6;+1000;1e-3;certified\r\n\
                16;1e-8;2500;0;\r\n";
    let study = with_points("", text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        values(&study)[..2],
        ["16 1e-8 2500000000 0 0.1 0.005", "16 1e-8 2500000000 0 0.1 0.01"]
            .map(|row| row.replace("2500000000", "2.5e9"))
    );
    assert_eq!((study.len(), &values(&study)[11][..]), (12, "8x4 1e-6 1e9 0.001 0.3 0.01"));
    assert_eq!(
        study.remarks(),
        [
            "points points.csv: left out, since they are results: status",
            "points points.csv: 1 line repeats an earlier one and adds no point"
        ]
    );
    let one = with_points("columns = [\"mesh\"]\n", "mesh,load,nonsense\n8,1,\n16,2,x\n").unwrap();
    assert_eq!((one.len(), one.remarks().len()), (12, 0));
    let own = with_points("", "mesh,ceiling\n8,5 GPa\n8,1e9\n").unwrap();
    let listed = "8 5e9 0.1 0.005";
    assert_eq!(values(&own)[0], listed);
}

/// What a query writes of a study over tables has their labels beside their keys.
#[test]
fn labels_of_tables_beside_their_keys_are_left_out() {
    let study = with_points("", "punch,punch.shape,mesh\nball,sphere,8\nlarger ball,sphere,16\n");
    let study = study.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(values(&study)[0].split_whitespace().next(), Some("sphere"));
    assert_eq!(
        study.remarks(),
        ["points points.csv: left out, since they name tables whose keys stand beside them: punch"]
    );
    for head in ["layers", "foundation.layers"] {
        let layered = format!(
            "{head},layer0_thickness,layer0_shear_modulus,layer0_poisson,mesh\ncoated,1 mm,1 GPa,0.3,8\n"
        );
        let study = with_points("", &layered).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((study.len(), study.remarks().len()), (6, 1));
    }
}

/// The file is kept with the study.
#[test]
fn points_are_read_again_from_a_stored_definition() {
    let study = with_points("", "mesh,tolerance\n8,1e-8\n16,1e-9\n").unwrap();
    let stored = Study::from_definition(&study.definition()).unwrap();
    assert_eq!(values(&stored), values(&study));
    assert_eq!(study.named_files().map(|(name, _)| name).collect::<Vec<_>>(), ["points.csv"]);
}

/// A file outside the study's directory may be anything, and is not repeated.
#[test]
fn a_file_from_elsewhere_is_not_quoted() {
    let mut files = |_: &str| {
        Ok(NamedFile { bytes: b"mesh,secret\n16,3\nsecret,1".to_vec(), may_quote: false })
    };
    let text = GOOD.replace("[sweep]", "[points]\nfile = \"../other.csv\"\n[sweep]");
    let said = Study::parse(&text, "study.toml", &mut files).unwrap_err().to_string();
    assert!(said.contains("line 1, value 2") && !said.contains("secret"), "{said}");
}

#[test]
fn points_are_left_out_by_any_condition_and_kept_by_any() {
    let all = with("");
    assert_eq!((all.points().len(), all.excluded(), all.has_conditions()), (6, 0, false));
    let left =
        with("[[exclude]]\nwhen = \"mu > 0.25\"\n[[exclude]]\nwhen = \"friction.mu < 0.15\"\n");
    assert_eq!(values(&left), ["0.2 0.005", "0.2 0.01"]);
    assert_eq!(left.excluded(), 4);
    let kept = with(
        "[[keep]]\nwhen = \"mu == 0.1\"\n[[keep]]\nwhen = \"radius == 0.005\"\n\
         [[exclude]]\nwhen = \"mu == 0.3 && punch.radius < 0.007\"\n",
    );
    assert_eq!(values(&kept), ["0.1 0.005", "0.1 0.01", "0.2 0.005"]);
    // A point keeps its index, and its key.
    let indices: Vec<usize> = kept.indices().collect();
    assert_eq!(indices, [0, 1, 2]);
    assert_eq!(left.indices().collect::<Vec<_>>(), [2, 3]);
    assert_eq!(left.points()[0].key, all.points()[2].key);
    assert_eq!(left.index(1), Some(3));
    assert_eq!(left.len(), 6);
}

#[test]
fn conditions_that_change_nothing_are_remarked() {
    let study = with(
        "[[exclude]]\nwhen = \"mu > 2\"\n[[keep]]\nwhen = \"mesh == 16\"\n\
         [[exclude]]\nwhen = \"mu > 0.25\"\n",
    );
    assert_eq!(
        study.remarks(),
        ["[[exclude]] `mu > 2` holds at no point", "[[keep]] `mesh == 16` holds at every point"]
    );
    assert_eq!((study.points().len(), study.excluded()), (4, 2));
}

/// A cone has no radius, and a sphere of no radius is none.
#[test]
fn what_is_left_out_need_make_no_sense() {
    let text = GOOD.replace("\"10 mm\"]", "\"10 mm\", \"-3 mm\"]");
    assert!(read(&text).is_err());
    let study = read(&format!("{text}[[exclude]]\nwhen = \"radius <= 0\"\n")).unwrap();
    assert_eq!((study.points().len(), study.excluded()), (6, 3));
    // The point that makes no sense with the others at their first values is left out as well.
    let text = GOOD.replace("[\"5 mm\",", "[\"-3 mm\", \"5 mm\",");
    let study = read(&format!("{text}[[exclude]]\nwhen = \"radius <= 0\"\n")).unwrap();
    assert_eq!((study.points().len(), study.excluded()), (6, 3));
}

/// A key that only some values of an axis give is `null` at the others.
#[test]
fn labels_and_keys_of_tables_are_names() {
    let text = GOOD.replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]",
        "punch = [{ shape = \"sphere\", radius = \"5 mm\", label = \"ball\" }, { shape = \"cone\", \
         angle = \"5 deg\" }]",
    );
    let study = read(&format!("{text}[[exclude]]\nwhen = \"punch == 'ball' && mu < 0.15\"\n"));
    assert_eq!(study.unwrap().excluded(), 1);
    for (condition, excluded) in
        [("radius == null", 3), ("shape == 'cone'", 3), ("radius > 0.001", 3), ("angle != null", 3)]
    {
        let study = read(&format!("{text}[[exclude]]\nwhen = \"{condition}\"\n")).unwrap();
        assert_eq!(study.excluded(), excluded, "{condition}");
    }
}

#[test]
fn a_stored_definition_leaves_out_the_same_points() {
    let study = with("[[exclude]]\nwhen = \"mu > 0.25\"\n");
    let stored = Study::from_definition(&study.definition()).unwrap();
    assert_eq!(values(&stored), values(&study));
    assert_eq!(stored.excluded(), 2);
}

#[test]
fn blocks_of_points_are_all_points_in_their_order() {
    let (all, left) = (with(""), with("[[exclude]]\nwhen = \"mu == 0.2\"\n"));
    let none = all.restricted(Vec::new()).unwrap();
    for (study, at_once, lengths) in [
        (&all, 0, &[1; 6][..]),
        (&all, 1, &[1; 6]),
        (&all, 4, &[4, 2]),
        (&all, 6, &[6]),
        (&left, 3, &[3, 1]),
        (&left, 9, &[4]),
        (&none, 9, &[]),
    ] {
        let blocks: Vec<_> = study.point_blocks(at_once).collect();
        assert_eq!(blocks.iter().map(Vec::len).collect::<Vec<_>>(), lengths, "{at_once} at once");
        assert_eq!(blocks.concat(), study.points(), "{at_once} at once");
    }
}

/// A study of 10⁹ points is decided where a part of it is taken.
#[test]
fn parts_of_a_large_study_leave_out_their_own_points() {
    let axes = "\"friction.mu\" = { from = 0, to = 1, count = 100000 }\n\
                \"foundation.base.poisson\" = { from = 0, to = 0.45, count = 10000 }\n";
    let text = GOOD.replace("\"friction.mu\" = [0.1, 0.2, 0.3]\n", axes).replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]\n",
        "[[keep]]\nwhen = \"mu > 0.5 && poisson < 0.225\"\n",
    );
    let study = Study::parse_sharded(&text, "study.toml", &mut no_files).unwrap();
    assert_eq!((study.len(), study.is_listed(), study.excluded()), (1_000_000_000, false, 0));
    let part = study.restricted(vec![0, 700_000_000, 700_000_001, 700_009_999]).unwrap();
    assert_eq!(part.indices().collect::<Vec<_>>(), [700_000_000, 700_000_001]);
    assert_eq!(part.excluded(), 2);
}

/// A ladder of meshes at one friction, and a range of frictions on one mesh.
const BLOCKS: &str = r#"
[[sweep]]
mesh = [8, 16, 32]
[[sweep]]
"friction.mu" = [0.1, 0.3]
"punch.radius" = ["5 mm", "10 mm"]
"#;

fn of_blocks(blocks: &str) -> Result<Study, StudyError> {
    let scene = &GOOD[..GOOD.find("[sweep]").unwrap()];
    read(&format!("{scene}{blocks}"))
}

/// A key that a block does not vary has the scene's value; a point of two blocks counts once.
#[test]
fn blocks_of_axes_are_joined() {
    let study = of_blocks(BLOCKS).unwrap_or_else(|error| panic!("{error}"));
    let columns: Vec<String> = study.axes().map(|axis| axis.column().into_owned()).collect();
    assert_eq!(columns, ["mesh", "mu", "radius"]);
    let rows: Vec<Vec<String>> = study
        .points()
        .iter()
        .map(|point| point.values.iter().map(ToString::to_string).collect())
        .collect();
    let expected = [
        ["8", "0.3", "0.01"],
        ["16", "0.3", "0.01"],
        ["32", "0.3", "0.01"],
        ["16", "0.1", "0.005"],
        ["16", "0.1", "0.01"],
        ["16", "0.3", "0.005"],
    ];
    assert_eq!(rows, expected.map(|row| row.map(str::to_owned).to_vec()));
    assert_eq!(study.remarks().len(), 1, "{:?}", study.remarks());
}

#[test]
fn blocks_without_meaning_are_refused_at_their_place() {
    let mut said = String::new();
    for (name, blocks) in [
        ("two in one block", "[[sweep]]\nmesh = [8]\nnumerics.mesh = [16]\n"),
        (
            "overlapping",
            "[[sweep]]\npunch.radius = [1]\n[[sweep]]\npunch = [{ shape = \"cone\", angle = 1 }]\n",
        ),
        ("unknown", "[[sweep]]\nmesh = [8]\n[[sweep]]\nmash = [8]\n"),
        (
            "too many points",
            "[[sweep]]\nfriction.mu = { from = 0, to = 1, count = 150000 }\n\
             [[sweep]]\nfriction.mu = { from = 2, to = 3, count = 150000 }\n",
        ),
        (
            "halving",
            "[bisect]\naxis = \"mu\"\non = \"stick_area > 0\"\nto = \"1%\"\n\
             [[sweep]]\nfriction.mu = [0.1, 0.3]\n[[sweep]]\nmesh = [8, 16]\n",
        ),
    ] {
        match of_blocks(blocks) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said += &format!("## {name}\n{error}\n\n"),
        }
    }
    insta::assert_snapshot!(said);
}

#[test]
fn a_setting_leaves_every_block() {
    let scene = &GOOD[..GOOD.find("[sweep]").unwrap()];
    let text = format!("{scene}{BLOCKS}");
    let set = |settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|&set| set.to_owned()).collect();
        study::edit::with_settings(&text, "study.toml", &settings, &mut no_files).unwrap()
    };
    assert_eq!(read(&set(&["mesh=8"])).unwrap().axes().count(), 2);
    let single = set(&["mesh=8", "friction.mu=0.2", "punch.radius=5 mm"]);
    assert!(!single.contains("sweep") && read(&single).unwrap().len() == 1, "{single}");
}

/// The conditions of a large study are judged by whoever goes through its points.
#[test]
fn conditions_of_a_large_study_are_remarked_by_their_counts() {
    let text = GOOD.replace(
        "\"friction.mu\" = [0.1, 0.2, 0.3]\n",
        "\"friction.mu\" = { from = 0, to = 1, count = 150000 }\n",
    );
    let judged = |conditions: &str| {
        let text = format!("{text}{conditions}");
        let study = Study::parse_sharded(&text, "study.toml", &mut no_files).unwrap();
        assert!(!study.is_listed());
        let (mut excluded, mut holding) = (0, study::HoldingCounts::default());
        for index in 0..study.len() {
            let decision = study.decision(index).unwrap();
            excluded += usize::from(decision.is_excluded);
            holding = holding.with(decision.holding);
        }
        study.idle_conditions(excluded, &holding).map_err(|error| error.to_string())
    };
    let remarks = judged("[[exclude]]\nwhen = \"mu > 2\"\n[[exclude]]\nwhen = \"mu > 0.5\"\n");
    assert_eq!(remarks, Ok(vec!["[[exclude]] `mu > 2` holds at no point".to_owned()]));
    let refused = judged("[[keep]]\nwhen = \"radius > 7\"\n").unwrap_err();
    assert!(refused.contains("leave none of the study's 300000 points"), "{refused}");
}
