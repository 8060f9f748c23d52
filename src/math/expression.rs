//! Expressions that a user writes as text, such as `0.1 * sin(2 * PI * x)`, parsed once and evaluated many times.
//!
//! From loosest to tightest: `||`; `&&`; one comparison `< <= > >= == !=`; `+ -`; `* /`; sign; `^`, which groups to the right.
//! So `-x^2` is `-(x^2)`, `2^-1` is 0.5 and `a < b < c` is refused. A comparison gives 1 or 0; anything but 0 counts as true.
//! Every value is a double and nothing is an error at evaluation: `sqrt(-1)` is NaN, and what that means is the caller's matter.
//!
//! Ready-made parsers were looked at: they give a sign more weight than a power, or take functions of at most two arguments.

use super::jet::Jet;
use super::operator::{COMPARISON, FUNCTIONS, NEGATE, OPERATORS, Op, POWER};
use std::fmt::Write as _;

/// Longest text that is accepted [bytes].
const LENGTH_LIMIT: usize = 4096;
/// Deepest nesting of parentheses, calls, signs and powers, and most values that wait for an operator at one time.
const NESTING_LIMIT: usize = 64;

const CONSTANTS: [(&str, f64); 3] = [("PI", std::f64::consts::PI), ("E", std::f64::consts::E), ("TAU", std::f64::consts::TAU)];

/// A parsed expression.
#[derive(Clone, Debug)]
pub struct Expression {
    program: Vec<Op>,
    variables: Vec<String>,
}

impl Expression {
    /// Parses `text`, which may use the names in `variables` besides the functions and constants of `scene::Expr`.
    ///
    /// # Errors
    /// What is wrong and at which character (from 1); an unknown name is quoted together with the variables allowed.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, String> {
        if text.len() > LENGTH_LIMIT {
            return Err(format!("the expression has {} bytes, more than the {LENGTH_LIMIT} allowed", text.len()));
        }
        if text.trim().is_empty() {
            return Err("the expression is empty".to_owned());
        }
        let mut parser = Parser { text, at: 0, variables, program: Vec::new(), waiting: 0, nesting: 0 };
        parser.binary(0)?;
        parser.skip_space();
        if !parser.rest().is_empty() {
            return Err(parser.unexpected("an operator or the end"));
        }
        let parsed = Expression { program: parser.program, variables: variables.iter().map(|&name| name.to_owned()).collect() };
        Ok(if parsed.is_constant() { Self::constant(parsed.eval(&[])) } else { parsed })
    }

    /// The expression that is `value` everywhere.
    pub fn constant(value: f64) -> Self {
        Expression { program: vec![Op::Number(value)], variables: Vec::new() }
    }

    /// The value, `values` being in the order of the `variables` given to [`parse`](Self::parse); more values than that are ignored.
    ///
    /// # Panics
    /// If a variable that the expression uses has no value.
    pub fn eval(&self, values: &[f64]) -> f64 {
        let mut stack = [0.0; NESTING_LIMIT];
        let mut top = 0;
        for op in &self.program {
            top -= op.arity();
            stack[top] = match *op {
                Op::Number(value) => value,
                Op::Variable(index) => values[index],
                Op::Unary(f) => (f.value)(stack[top]),
                Op::Binary(f) => (f.value)(stack[top], stack[top + 1]),
                Op::Select if stack[top] != 0.0 => stack[top + 1],
                Op::Select => stack[top + 2],
            };
            top += 1;
        }
        stack[0]
    }

    /// The value with first and second derivatives, `values` being those of the variables as jets. Functions with jumps and kinks count as
    /// what they are beside them.
    ///
    /// # Panics
    /// If a variable that the expression uses has no value.
    pub fn jet(&self, values: &[Jet]) -> Jet {
        let mut stack = Vec::with_capacity(8);
        for op in &self.program {
            let from = stack.len() - op.arity();
            let arguments: &[Jet] = &stack[from..];
            let result = match (*op, arguments) {
                (Op::Number(value), _) => Jet::constant(value),
                (Op::Variable(index), _) => values[index],
                (Op::Unary(f), [a, ..]) => a.unary((f.value)(a.value), (f.derivatives)(a.value)),
                (Op::Binary(f), [a, b, ..]) => {
                    let (first, second) = (f.derivatives)(a.value, b.value);
                    a.binary(b, (f.value)(a.value, b.value), first, second)
                }
                (Op::Select, [condition, a, b]) => *if condition.value != 0.0 { a } else { b },
                _ => unreachable!("a program that the parser has not made"),
            };
            stack.truncate(from);
            stack.push(result);
        }
        stack[0]
    }

    /// Whether no variable occurs in it.
    pub fn is_constant(&self) -> bool {
        !self.program.iter().any(|op| matches!(op, Op::Variable(_)))
    }

    /// Whether the variable `name` occurs in it.
    pub fn uses(&self, name: &str) -> bool {
        self.program.iter().any(|op| matches!(op, Op::Variable(index) if self.variables[*index] == name))
    }
}

struct Parser<'a> {
    text: &'a str,
    /// Bytes read.
    at: usize,
    variables: &'a [&'a str],
    program: Vec<Op>,
    /// Values on the stack after the program so far.
    waiting: usize,
    nesting: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_space(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Takes `token`, if it is next.
    fn take(&mut self, token: &str) -> bool {
        self.skip_space();
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    fn push(&mut self, op: Op) -> Result<(), String> {
        self.waiting = self.waiting + 1 - op.arity();
        if self.waiting > NESTING_LIMIT {
            return Err(self.too_deep());
        }
        self.program.push(op);
        Ok(())
    }

    /// Operators of weight `least` and more, grouped to the left.
    fn binary(&mut self, least: u8) -> Result<(), String> {
        self.signed()?;
        let mut compared = false;
        loop {
            self.skip_space();
            let Some(&(text, weight, op)) = OPERATORS.iter().find(|(text, ..)| self.rest().starts_with(text)) else { return Ok(()) };
            if weight < least {
                return Ok(());
            }
            if weight == COMPARISON && std::mem::replace(&mut compared, true) {
                return Err(self.fault("comparisons cannot be chained; join two of them by `&&`"));
            }
            compared &= weight >= COMPARISON;
            self.at += text.len();
            self.binary(weight + 1)?;
            self.push(op)?;
        }
    }

    /// Signs, then a power. All recursion passes here, so that nesting is counted here.
    fn signed(&mut self) -> Result<(), String> {
        self.nesting += 1;
        if self.nesting > NESTING_LIMIT {
            return Err(self.too_deep());
        }
        if self.take("-") {
            self.signed()?;
            self.push(NEGATE)?;
        } else if self.take("+") {
            self.signed()?;
        } else {
            self.atom()?;
            if self.take("^") {
                self.signed()?;
                self.push(POWER)?;
            }
        }
        self.nesting -= 1;
        Ok(())
    }

    /// A number, a name, a call or parentheses.
    fn atom(&mut self) -> Result<(), String> {
        self.skip_space();
        let start = self.at;
        if self.take("(") {
            self.binary(0)?;
            return self.close();
        }
        let number = number_length(self.rest());
        if number > 0 {
            let digits = &self.rest()[..number];
            let value = digits.parse().ok().filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| self.fault(&format!("`{digits}` is not a number that a double can hold")))?;
            self.at += number;
            return self.push(Op::Number(value));
        }
        let rest = self.rest();
        let name = &rest[..rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len())];
        if name.is_empty() {
            return Err(self.unexpected("a number, a name or `(`"));
        }
        self.at += name.len();
        if let Some(index) = self.variables.iter().position(|&variable| variable == name) {
            return self.push(Op::Variable(index));
        }
        if let Some((_, value)) = CONSTANTS.iter().find(|(constant, _)| *constant == name) {
            return self.push(Op::Number(*value));
        }
        let function = FUNCTIONS.iter().chain(&[("if", Op::Select)]).find(|(function, _)| *function == name);
        let Some((_, op)) = function else {
            self.at = start;
            return Err(self.unknown(name));
        };
        self.call(name, *op)
    }

    fn call(&mut self, name: &str, op: Op) -> Result<(), String> {
        if !self.take("(") {
            return Err(self.unexpected(&format!("`(` after `{name}`")));
        }
        for argument in 0..op.arity() {
            if argument > 0 && !self.take(",") {
                return Err(self.unexpected(&format!("`,`, since `{name}` takes {} arguments,", op.arity())));
            }
            self.binary(0)?;
        }
        self.close()?;
        self.push(op)
    }

    fn close(&mut self) -> Result<(), String> {
        if self.take(")") { Ok(()) } else { Err(self.unexpected("an operator or `)`")) }
    }

    fn fault(&self, message: &str) -> String {
        format!("{message} (character {} of the expression)", self.text[..self.at].chars().count() + 1)
    }

    fn too_deep(&self) -> String {
        self.fault(&format!("the expression is nested more than {NESTING_LIMIT} deep"))
    }

    fn unexpected(&self, expected: &str) -> String {
        match self.rest().chars().next() {
            Some(found) => self.fault(&format!("{expected} expected, found `{}`", found.escape_debug())),
            None => self.fault(&format!("{expected} expected, found the end")),
        }
    }

    fn unknown(&self, name: &str) -> String {
        let mut message = format!("unknown name `{name}`");
        if let Some(meant) = self.meant(name) {
            _ = write!(message, ", did you mean `{meant}`?");
        }
        message.push_str("; variables here: ");
        match self.variables {
            [] => message.push_str("none"),
            variables => _ = write!(message, "{}", variables.join(", ")),
        }
        if self.rest()[name.len()..].trim_start().starts_with('(') {
            let functions: Vec<&str> = FUNCTIONS.iter().map(|(function, _)| *function).collect();
            _ = write!(message, "; functions: {}, if", functions.join(", "));
        }
        self.fault(&message)
    }

    /// The name that another one is most like: that of other languages, in other letters, or with a slip.
    fn meant(&self, name: &str) -> Option<&str> {
        let elsewhere =
            [("log", "ln"), ("pow", "^"), ("mod", "floor"), ("arcsin", "asin"), ("arccos", "acos"), ("arctan", "atan"), ("fabs", "abs")];
        if let Some((_, own)) = elsewhere.iter().find(|(other, _)| *other == name) {
            return Some(own);
        }
        let functions = FUNCTIONS.iter().map(|(function, _)| *function);
        let known = functions.chain(CONSTANTS.iter().map(|(constant, _)| *constant)).chain(self.variables.iter().copied());
        let near = known.map(|own| (strsim::osa_distance(&name.to_lowercase(), &own.to_lowercase()), own)).min()?;
        (near.0 == 0 || 3 * near.0 <= near.1.len()).then_some(near.1)
    }
}

/// Length of the number that `text` begins with, 0 if there is none: `12`, `1.5`, `.5`, `2.`, `1e-3`.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let whole = digits(0);
    let mut length = whole;
    if bytes.get(length) == Some(&b'.') {
        let fraction = digits(length + 1);
        if whole + fraction == 0 {
            return 0;
        }
        length += 1 + fraction;
    }
    if length > 0 && matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        if bytes.len() > length + 1 + sign {
            let exponent = digits(length + 1 + sign);
            if exponent > 0 {
                length += 1 + sign + exponent;
            }
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str) -> f64 {
        let parsed = Expression::parse(text, &["x", "y"]).unwrap_or_else(|message| panic!("{text}: {message}"));
        parsed.eval(&[3.0, -2.0])
    }

    #[test]
    fn known_values() {
        let table = [
            ("1", 1.0),
            ("-x^2", -9.0),
            ("(-x)^2", 9.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("-2^-2", -0.25),
            ("x^-y", 9.0),
            ("2*-x", -6.0),
            ("--x", 3.0),
            ("+x - -1", 4.0),
            ("8/4/2", 1.0),
            ("8 - 4 - 2", 2.0),
            ("8/4*2", 4.0),
            ("1+2*3", 7.0),
            ("(1+2)*3", 9.0),
            ("2*x^2", 18.0),
            ("1e-3", 0.001),
            ("1.5E+2", 150.0),
            (".5 + 2.", 2.5),
            ("2*E", 2.0 * std::f64::consts::E),
            ("PI/TAU", 0.5),
            ("1+1 < 3", 1.0),
            ("1 < 2 == 0", f64::NAN),
            ("x > 2 && y < -1", 1.0),
            ("x > 2 && y > -1 || 1", 1.0),
            ("1 || 1 && 0", 1.0),
            ("(1 || 1) && 0", 0.0),
            ("x <= 3", 1.0),
            ("x >= 4", 0.0),
            ("x == 3", 1.0),
            ("x != 3", 0.0),
            ("if(x < 0, sqrt(y), 5)", 5.0),
            ("if(x > 0, 1 + if(y > 0, 10, 20), 3)", 21.0),
            ("max(max(1, min(x, 7)), y)", 3.0),
            ("min(1, max(2, 3)) + max(4, 5) * 2", 11.0),
            ("atan2(1, 0) * 2 / PI", 1.0),
            ("sign(0) + sign(-4) + 2 * sign(x)", 1.0),
            ("floor(-1.5) + ceil(-1.5) + round(2.5)", 0.0),
            ("ln(exp(2)) + log10(1000) + sqrt(16) + abs(y)", 11.0),
            ("sin(PI/6)", 0.5),
            ("cosh(0) + sinh(0) + tanh(0)", 1.0),
        ];
        for (text, expected) in table {
            if expected.is_nan() {
                assert!(Expression::parse(text, &["x", "y"]).unwrap_err().contains("chained"), "{text}");
            } else {
                let found = value(text);
                assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{text} = {found}, not {expected}");
            }
        }
    }

    #[test]
    fn not_a_number_is_not_hidden() {
        for text in ["sqrt(y)", "min(sqrt(y), 1)", "max(1, sqrt(y))", "sign(sqrt(y))"] {
            assert!(value(text).is_nan(), "{text}");
        }
    }

    #[test]
    fn wrong_texts_are_explained() {
        let table = [
            ("", "empty"),
            ("  ", "empty"),
            ("x +", "found the end (character 4"),
            ("(x", "`)` expected"),
            ("x)", "found `)`"),
            ("2 x", "found `x` (character 3"),
            ("q + 1", "unknown name `q`; variables here: x, y (character 1"),
            ("2 * pi", "unknown name `pi`, did you mean `PI`?"),
            ("log(x)", "did you mean `ln`?"),
            ("foo(x)", "; functions: sin, cos"),
            ("sqr(x)", "did you mean `sqrt`?"),
            ("sin x", "`(` after `sin` expected"),
            ("sin()", "found `)`"),
            ("sin(1, 2)", "found `,`"),
            ("min(1)", "takes 2 arguments"),
            ("if(1, 2)", "takes 3 arguments"),
            ("1e999", "double"),
            ("x = 1", "found `=`"),
            ("x < y < 1", "chained"),
            ("é", "unknown name `é`"),
            ("1 $ 2", "found `$`"),
            (".", "found `.`"),
        ];
        for (text, expected) in table {
            let message = Expression::parse(text, &["x", "y"]).unwrap_err();
            assert!(message.contains(expected), "{text:?}: {message}");
        }
        assert!(Expression::parse("x", &[]).unwrap_err().contains("variables here: none"));
    }

    #[test]
    fn limits_hold() {
        let nested = |depth: usize| format!("{}1{}", "(".repeat(depth), ")".repeat(depth));
        assert!(Expression::parse(&nested(60), &[]).is_ok());
        for text in [nested(2000), "-".repeat(4000) + "1", "1^".repeat(2000) + "1", "sin(".repeat(900), "1||1&&1<1+1*(".repeat(300)] {
            assert!(Expression::parse(&text, &[]).unwrap_err().contains("nested"), "{text}");
        }
        assert!(Expression::parse(&"1+1*(".repeat(40), &[]).is_err());
        assert_eq!(Expression::parse(&("1+".repeat(2000) + "1"), &[]).map(|sum| sum.eval(&[])), Ok(2001.0));
        assert!(Expression::parse(&"1".repeat(4097), &[]).unwrap_err().contains("4096"));
    }

    #[test]
    fn what_it_depends_on() {
        let parsed = Expression::parse("2 * t + 0 * x", &["x", "y", "t"]).unwrap();
        assert!(parsed.uses("t") && parsed.uses("x") && !parsed.uses("y") && !parsed.is_constant());
        let constant = Expression::parse("2 * PI", &["x"]).unwrap();
        assert!(constant.is_constant() && !constant.uses("x"));
        assert_eq!(Expression::constant(7.0).eval(&[]), 7.0);
    }

    /// Derivatives against central differences, for every function and operator.
    #[test]
    fn jets_are_derivatives() {
        let texts = [
            "sin(x*y)",
            "cos(x+y^2)",
            "tan(0.1*x*y)",
            "asin(0.1*x*y)",
            "acos(0.1*x*y)",
            "atan(x*y)",
            "atan2(x^2, y)",
            "sinh(x-y)",
            "cosh(x*y/3)",
            "tanh(x/y)",
            "exp(x*y/2)",
            "ln(x^2+y^2)",
            "log10(x*y^2+3)",
            "sqrt(x^2+y)",
            "abs(y)*x^2",
            "min(x*y, y^2)",
            "max(x*y, y^2)",
            "x^y",
            "x^3*y^2",
            "(-x)^3*y",
            "-x*y + x/y - 2",
            "if(x > 0, x^2*y, 7)",
            "x*y*(x > y) + sign(x)*x^2 + floor(x)*y^2 + y*round(x) + ceil(y)*x",
        ];
        for text in texts {
            let f = Expression::parse(text, &["x", "y"]).unwrap();
            let (x, y) = (1.3, -0.7);
            let (x, y) = if text == "x^y" || text.starts_with("log10") { (x, 0.7) } else { (x, y) };
            let jet = f.jet(&[Jet::variable(x, 0), Jet::variable(y, 1)]);
            assert_eq!(jet.value, f.eval(&[x, y]), "{text}");
            let e = 1e-4;
            let at = |i: i32, j: i32| f.eval(&[x + e * f64::from(i), y + e * f64::from(j)]);
            let first = [(at(1, 0) - at(-1, 0)) / (2.0 * e), (at(0, 1) - at(0, -1)) / (2.0 * e)];
            let second = [
                (at(1, 0) - 2.0 * at(0, 0) + at(-1, 0)) / (e * e),
                (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4.0 * e * e),
                (at(0, 1) - 2.0 * at(0, 0) + at(0, -1)) / (e * e),
            ];
            let h = &jet.hessian;
            assert!(jet.gradient.norm() > 0.01 && h.norm() > 0.01, "{text}: {jet:?}");
            for (a, b) in first.into_iter().chain(second).zip([jet.gradient[0], jet.gradient[1], h[(0, 0)], h[(0, 1)], h[(1, 1)]]) {
                assert!((a - b).abs() < 1e-6 * (1.0 + b.abs()), "{text}: {a} {b}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in r"\PC{0,80}") {
            let _ = Expression::parse(&text, &["x"]).map(|parsed| parsed.eval(&[1.0]));
        }

        #[test]
        fn no_sequence_of_tokens_panics(tokens in prop::collection::vec(prop::sample::select(vec![
            "(", ")", ",", "+", "-", "*", "/", "^", "<", "<=", "==", "&&", "||", "sin", "atan2(", "if(", "x", "1", "2.", ".", "1e", "e-", "PI", " ", "é",
        ]), 0..200)) {
            let _ = Expression::parse(&tokens.concat(), &["x"]).map(|parsed| parsed.eval(&[1.0]));
        }

        #[test]
        fn sums_and_products_agree_with_rust(a in -9.0..9.0f64, b in -9.0..9.0f64, c in 0.1..9.0f64) {
            let parsed = Expression::parse("-a^2 + b * c - a / c ^ 2", &["a", "b", "c"]).unwrap();
            let expected = -(a * a) + b * c - a / (c * c);
            prop_assert!((parsed.eval(&[a, b, c]) - expected).abs() <= 1e-13 * (1.0 + expected.abs() + a * a / (c * c)));
        }
    }
}
