//! Cursor over the bytes of a file that is text, binary, or both in turns. Every read is checked against the file's end.

use super::Fault;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Coding {
    #[default]
    Text,
    LittleEndian,
    BigEndian,
}

/// The file's bytes and how far they are read.
#[derive(Default)]
pub struct Input<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub coding: Coding,
}

impl<'a> Input<'a> {
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        let at = match self.coding {
            Coding::Text => format!("line {}", self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count() + 1),
            _ => format!("byte {}", self.at),
        };
        Fault { at: Some(at), message: message.into() }
    }

    /// Goes past the next line that starts with `$` and returns the rest of it; `None` at the end of the file.
    pub fn next_section(&mut self) -> Option<String> {
        while self.at < self.bytes.len() {
            let line = self.bytes[self.at..].split(|&b| b == b'\n').next().unwrap_or(&[]);
            if let [b'$', name @ ..] = line {
                self.at += line.len();
                return Some(String::from_utf8_lossy(name).trim().to_string());
            }
            self.at += line.len() + 1;
        }
        self.at = self.bytes.len();
        None
    }

    /// Goes past the next occurrence of a text; stays if there is none.
    pub fn skip_past(&mut self, text: &[u8]) -> bool {
        let found = self.bytes[self.at..].windows(text.len()).position(|w| w == text);
        if let Some(k) = found {
            self.at += k + text.len();
            self.end_line();
        }
        found.is_some()
    }

    /// Goes past blanks up to and with the end of the line.
    pub fn end_line(&mut self) {
        while let Some(b) = self.bytes.get(self.at).filter(|b| b.is_ascii_whitespace()) {
            self.at += 1;
            if *b == b'\n' {
                break;
            }
        }
    }

    pub fn word(&mut self) -> Result<String, Fault> {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.fault("the file ends too early"));
        }
        self.at += length;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    pub fn number<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, Fault> {
        let word = self.word()?;
        word.parse().map_err(|_| self.fault(format!("`{word}` is not {expected}")))
    }

    /// A text in double quotes, on one line.
    pub fn quoted(&mut self) -> Result<String, Fault> {
        let line = self.bytes[self.at..].split(|&b| b == b'\n').next().unwrap_or(&[]);
        let quotes: Vec<usize> = (0..line.len()).filter(|&k| line[k] == b'"').collect();
        let (Some(first), Some(last)) = (quotes.first(), quotes.last()) else {
            return Err(self.fault("expected a name in double quotes"));
        };
        let name = String::from_utf8_lossy(line.get(first + 1..*last).unwrap_or(&[])).into_owned();
        self.at += line.len();
        if name.is_empty() { Err(self.fault("expected a name in double quotes")) } else { Ok(name) }
    }

    pub fn raw<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let Some(raw) = self.bytes[self.at..].first_chunk::<N>() else { return Err(self.fault("the file ends too early")) };
        self.at += N;
        let mut raw = *raw;
        if self.coding == Coding::BigEndian {
            raw.reverse();
        }
        Ok(raw)
    }

    /// A 4-byte integer.
    pub fn int(&mut self) -> Result<i64, Fault> {
        if self.coding == Coding::Text { self.number("a whole number") } else { Ok(i32::from_le_bytes(self.raw()?).into()) }
    }

    /// An 8-byte integer without sign.
    pub fn size(&mut self) -> Result<u64, Fault> {
        if self.coding == Coding::Text { self.number("a whole number") } else { Ok(u64::from_le_bytes(self.raw()?)) }
    }

    pub fn real(&mut self) -> Result<f64, Fault> {
        if self.coding == Coding::Text { self.number("a number") } else { Ok(f64::from_le_bytes(self.raw()?)) }
    }

    /// A count of things of at least one byte each.
    pub fn count(&mut self, what: &str) -> Result<u64, Fault> {
        let count = self.size()?;
        let left = self.bytes.len() - self.at;
        if count > left as u64 {
            return Err(self.fault(format!("{count} {what} are announced, but only {left} bytes follow")));
        }
        Ok(count)
    }

    /// A count that is text in binary files too, alone on its line.
    pub fn text_count(&mut self, what: &str) -> Result<u64, Fault> {
        let coding = std::mem::replace(&mut self.coding, Coding::Text);
        let count = self.count(what)?;
        self.coding = coding;
        self.end_line();
        Ok(count)
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: u64) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.at..];
        let Some(taken) = usize::try_from(count).ok().and_then(|n| rest.get(..n)) else {
            return Err(self.fault(format!("{count} bytes are needed, but only {} follow", rest.len())));
        };
        self.at += taken.len();
        Ok(taken)
    }
}
