//! The notation in which lists of columns of results are written.

/// Makes a list of columns. Each line gives the role, the name, a label in parentheses if the words
/// of the name are none, the dimension (`Text` if the values are texts), the meaning and the
/// source.
macro_rules! result_columns {
    (@dimension Text) => { $crate::units::Dimension::Pure };
    (@dimension $dimension:ident) => { $crate::units::Dimension::$dimension };
    (@is_numeric Text) => { false };
    (@is_numeric $dimension:ident) => { true };
    (@label) => { None };
    (@label $label:literal) => { Some($label) };
    ($(
        $role:ident $name:literal $(($label:literal))? $dimension:ident $meaning:literal
        $source:expr;
    )*) => {
        &[$($crate::columns::column::Column {
            name: std::borrow::Cow::Borrowed($name),
            dimension: result_columns!(@dimension $dimension),
            role: $crate::columns::column::Role::$role,
            meaning: $meaning,
            label: result_columns!(@label $($label)?),
            is_numeric: result_columns!(@is_numeric $dimension),
            source: $source,
        },)*]
    };
}

/// Reads a whole number from the outcome of the last increment.
macro_rules! integer {
    ($($field:ident).+) => {
        $crate::columns::column::ColumnSource::End(|end| {
            $crate::value::Value::Integer(end.$($field).+ as u64)
        })
    };
}

pub(crate) use {integer, result_columns};
