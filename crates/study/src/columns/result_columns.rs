//! The notation in which lists of columns of results are written.

/// Makes a list of columns. Each line gives the role, the name, a label in parentheses if the words
/// of the name are none, the dimension (`Text` if the values are texts, `Count` if they are whole
/// numbers), the meaning and the source.
macro_rules! result_columns {
    (@dimension Text) => { $crate::units::Dimension::Pure };
    (@dimension Count) => { $crate::units::Dimension::Pure };
    (@dimension $dimension:ident) => { $crate::units::Dimension::$dimension };
    (@values Text) => { $crate::value::ValueType::Text };
    (@values Count) => { $crate::value::ValueType::Integer };
    (@values $dimension:ident) => { $crate::value::ValueType::Number };
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
            values: result_columns!(@values $dimension),
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
