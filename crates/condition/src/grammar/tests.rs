//! Tests of the grammar: what binds how tightly, what stands for itself, what is refused where.

use proptest::prelude::*;

use super::*;

/// Returns a tree as an expression with all its brackets.
fn bracketed(written: &Written) -> String {
    let list = |parts: &[Written]| parts.iter().map(bracketed).collect::<Vec<_>>().join(", ");
    match written {
        Written::Constant(FilterValue::Text(text)) => format!("{text:?}"),
        Written::Constant(FilterValue::Truth(truth)) => truth.to_string(),
        Written::Constant(FilterValue::Integer(number)) => number.to_string(),
        Written::Constant(FilterValue::Number(number)) => format!("{number:?}"),
        Written::Constant(FilterValue::Missing) => "null".to_owned(),
        Written::Name(name) => name.clone(),
        Written::Not(value) => format!("!({})", bracketed(value)),
        Written::Negated(value) => format!("-({})", bracketed(value)),
        Written::Infix(operator, a, b) => {
            format!("({} {} {})", bracketed(a), sign(*operator), bracketed(b))
        }
        Written::Choice(parts) => {
            let [condition, yes, no] = parts.as_ref().each_ref().map(bracketed);
            format!("({condition} ? {yes} : {no})")
        }
        Written::List(elements) => format!("[{}]", list(elements)),
        Written::Call(name, arguments) => format!("{name}({})", list(arguments)),
        Written::Method(value, name, arguments) => {
            format!("({}).{name}({})", bracketed(value), list(arguments))
        }
        Written::Foreign(what) => format!("«{what}»"),
    }
}

fn sign(operator: InfixOperator) -> &'static str {
    match operator {
        InfixOperator::Or => "||",
        InfixOperator::And => "&&",
        InfixOperator::In => "in",
        InfixOperator::Compare(Relation::Equal) => "==",
        InfixOperator::Compare(Relation::NotEqual) => "!=",
        InfixOperator::Compare(Relation::Less) => "<",
        InfixOperator::Compare(Relation::LessOrEqual) => "<=",
        InfixOperator::Compare(Relation::Greater) => ">",
        InfixOperator::Compare(Relation::GreaterOrEqual) => ">=",
        InfixOperator::Calculate(Arithmetic::Plus) => "+",
        InfixOperator::Calculate(Arithmetic::Minus) => "-",
        InfixOperator::Calculate(Arithmetic::Times) => "*",
        InfixOperator::Calculate(Arithmetic::Over) => "/",
        InfixOperator::Calculate(Arithmetic::Modulo) => "%",
    }
}

fn tree(text: &str) -> String {
    bracketed(&read(text).unwrap_or_else(|error| panic!("{text}: {error}")))
}

/// The trees are those that the parser of the crate `cel` 0.15 made; the two were held against each
/// other on 200 000 random texts before that parser was replaced by this one.
#[test]
fn operators_bind_as_in_cel() {
    for (text, expected) in [
        ("a || b && c == d + e * f", "(a || (b && (c == (d + (e * f)))))"),
        ("a - b - c", "((a - b) - c)"),
        ("a < b < c", "((a < b) < c)"),
        ("a in [1, 2] == b", "((a in [1, 2]) == b)"),
        ("a ? b : c ? d : e", "(a ? b : (c ? d : e))"),
        ("(a ? b : c) ? d : e", "((a ? b : c) ? d : e)"),
        ("!a == b", "(!(a) == b)"),
        ("!!a", "a"),
        ("- -a", "a"),
        ("---a", "-(a)"),
        ("-a.b", "-(a.b)"),
        ("-a * b", "(-(a) * b)"),
        ("1 -1", "(1 - 1)"),
        ("2 - -1", "(2 - -1)"),
        ("-(1)", "-(1)"),
        ("a.b.c", "a.b.c"),
        ("(a).b[0].c[-1]", "a.b[0].c[-1]"),
        (".a.b", ".a.b"),
        ("a.contains('x') && b.f(1, 2)", "((a).contains(\"x\") && (b).f(1, 2))"),
        ("abs(a - b)", "abs((a - b))"),
        ("a in []", "(a in [])"),
        ("a in [1,]", "(a in [1])"),
        ("a // a comment\n + b", "(a + b)"),
        ("a.b[c]", "«`[…]` with anything but a number of an entry»"),
        ("1.a", "«`.a` of a value»"),
        ("[1].all(x, x > 0)", "«a macro such as all() or exists()»"),
        ("b'bytes'", "«b\"…\"»"),
    ] {
        assert_eq!(tree(text), expected, "{text}");
    }
}

#[test]
fn values_stand_for_themselves() {
    for (text, expected) in [
        ("0x1F", "31"),
        ("-0x10", "-16"),
        ("12u", "12"),
        ("18446744073709551615u", "1.8446744073709552e19"),
        ("-9223372036854775808", "-9223372036854775808"),
        (".5", "0.5"),
        ("-1.5e-3", "-0.0015"),
        ("1e3", "1000.0"),
        ("null", "null"),
        (r#"'a"b'"#, r#""a\"b""#),
        (r"'\x41\u00e9\U0001f431\101\n\?'", "\"Aé🐱A\\n?\""),
        (r#"r"\a\n""#, r#""\\a\\n""#),
        ("'''a'b\r\nc'''", r#""a'b\nc""#),
        ("''", r#""""#),
    ] {
        assert_eq!(tree(text), expected, "{text}");
    }
}

#[test]
fn faults_say_what_is_wrong_and_where() {
    for (text, place, fault) in [
        ("a b", 3, "unexpected 'b'"),
        ("a >", 4, "unexpected end of the expression"),
        ("a > ) b", 5, "unexpected ')'"),
        ("(a", 3, "missing ')' at end of the expression"),
        ("(a b)", 4, "unexpected 'b'"),
        ("a ? b", 6, "missing ':' at end of the expression"),
        ("a.1", 2, "unexpected '.1'"),
        ("a.in", 3, "unexpected 'in'"),
        ("abs(a,)", 7, "unexpected ')'"),
        ("[1,,2]", 4, "unexpected ','"),
        ("!-a", 2, "unexpected '-'"),
        ("a => b", 3, "unexpected '=>'"),
        ("a # b", 3, "unexpected '#'"),
        ("é == 1", 1, "unexpected 'é'"),
        ("if == 1", 1, "reserved identifier: if"),
        ("9223372036854775808 > a", 1, "a number that is too large"),
        ("1e999 > a", 1, "a number that is too large"),
        ("a == 'b", 6, "missing ' for the text that begins"),
        ("a == '''b'", 6, "missing ''' for the text that begins"),
        ("a == 'b\nc'", 6, "missing ' for the text that begins"),
        (r"a == '\q'", 7, r"unknown escape '\q'"),
        (r"a == '\ud800'", 7, r"unknown escape '\u'"),
    ] {
        match read(text).unwrap_err() {
            FilterError::Syntax { message, position, .. } => {
                assert_eq!((position, message.as_str()), (place, fault), "{text}");
            }
            other => panic!("{text}: {other}"),
        }
    }
    for text in ["{a: 1}", "a{b: 1}"] {
        assert_eq!(read(text).unwrap_err(), FilterError::Unsupported("`{…}`".to_owned()));
    }
}

/// Names of which there is none.
struct Nameless;

impl crate::ConditionNames for Nameless {
    fn find(&self, _: &str) -> Result<usize, crate::UnknownColumn> {
        Err(crate::UnknownColumn::default())
    }
    fn kind(&self, _: usize) -> crate::ValueKind {
        crate::ValueKind::Unknown
    }
}

/// Trees are as deep as they have operators, also of brackets in brackets, and what goes through
/// the deepest has enough with the smallest stack that the program begins on.
#[test]
fn long_chains_are_refused_before_they_fill_the_stack() {
    let chain = |operators: usize| format!("1{} > 0", "+1".repeat(operators - 1));
    let bracketed = "(".repeat(8) + "1" + &format!("{})", "+1".repeat(200)).repeat(8) + " > 0";
    let methods = format!("''{} == ''", ".f()".repeat(900));
    for text in [format!("1{}", "+1".repeat(2047)), chain(513), bracketed, methods] {
        assert!(text.len() <= crate::Condition::LONGEST, "{}", text.len());
        let error = read(&text).unwrap_err().to_string();
        assert!(error.starts_with("more than 512 operators"), "{error}");
    }
    let going_through = move || {
        let condition = crate::Condition::new(&chain(512), &Nameless).unwrap();
        assert!(!condition.clone().uses(0));
        assert_eq!(condition.truth(&|_| FilterValue::Missing), Ok(Some(true)));
    };
    let thread = std::thread::Builder::new().stack_size(1 << 20).spawn(going_through).unwrap();
    thread.join().unwrap();
}

/// Makes random expressions of all that the grammar has.
fn expressions() -> impl Strategy<Value = String> {
    let leaves = [
        "a", "b.c", "d[0]", "1", "-2", "2.5", "true", "null", "'x'", "0x1f", "3u", ".q", "[1, 2]",
        "[]",
    ];
    let leaf = prop::sample::select(leaves.map(str::to_owned).to_vec());
    leaf.prop_recursive(6, 60, 4, |inner| {
        let signs = ["==", "<", ">=", "&&", "||", "+", "-", "*", "/", "%", "in"];
        prop_oneof![
            (inner.clone(), prop::sample::select(signs.to_vec()), inner.clone())
                .prop_map(|(a, sign, b)| format!("{a} {sign} {b}")),
            (inner.clone(), inner.clone(), inner.clone())
                .prop_map(|(a, b, c)| format!("({a}) ? ({b}) : {c}")),
            (prop::sample::select(vec!["!", "-", "!!", "- -"]), inner.clone())
                .prop_map(|(sign, a)| format!("{sign}({a})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a}).startsWith({b})")),
            prop::collection::vec(inner.clone(), 0..3)
                .prop_map(|parts| format!("abs({})", parts.join(","))),
            inner.prop_map(|a| format!("({a})")),
        ]
    })
}

proptest! {
    /// Brackets that say what the grammar says anyway change nothing.
    #[test]
    fn brackets_do_not_change_a_tree(text in expressions()) {
        if let Ok(written) = read(&text) {
            let bracketed = bracketed(&written);
            if !bracketed.contains('«') {
                prop_assert_eq!(tree(&bracketed), bracketed, "{}", text);
            }
        }
    }

    #[test]
    fn no_text_panics(text in any::<String>(), quoted in "['\"\\\\rRbxuU0-9a-f\r\n ]{0,12}") {
        let _ = (read(&text), read(&quoted));
    }
}
