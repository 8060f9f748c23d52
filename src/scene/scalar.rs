//! A scalar of place: an expression, or a field of the mesh file.

use super::Expr;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number, an expression, or `{ field = "name" }`, a field of one component that the mesh file (or `[flatten]`) has.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Scalar {
    /// A number or an expression.
    Expr(Expr),
    /// A field of the mesh.
    Field(MeshField),
}

/// Field of the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshField {
    /// The field's name in the file.
    pub field: String,
    /// Factor on the field's values, of the variables that an expression in its place may have. With `times = "t"` a logarithm of growth
    /// comes into force as a power, so that large growth is spread evenly over the steps. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<Expr>,
}

impl<'de> Deserialize<'de> for Scalar {
    // By hand, because an untagged enum would lose the place of a wrong value in the file.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = Scalar;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, an expression in quotes or { field = \"name\" }")
            }
            fn visit_f64<E>(self, v: f64) -> Result<Scalar, E> {
                Ok(Scalar::Expr(Expr::Number(v)))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Scalar, E> {
                Ok(Scalar::Expr(Expr::Number(v as f64)))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Scalar, E> {
                Ok(Scalar::Expr(Expr::Number(v as f64)))
            }
            fn visit_str<E>(self, v: &str) -> Result<Scalar, E> {
                Ok(Scalar::Expr(Expr::Text(v.to_owned())))
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Scalar, A::Error> {
                MeshField::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Scalar::Field)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
