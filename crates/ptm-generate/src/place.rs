//! Places in a file, in the syntax of damages: `width`, `bias[5]`, `plane[last].da+7`, `file-1 row`.

use std::ops::Range;
use std::str::FromStr;

use super::{model::Model, output::GeneratedFile};
use crate::error::{Error, Result};

/// A place: a field or a part of it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct DamagePlace {
    name: String,
    which: Selector,
    segment: Option<StreamPart>,
    offset: Offset,
}

/// A selection among fields with the same name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Selector {
    Nth(usize),
    Last,
    All,
    /// The field of the predicted plane with the highest rank.
    Predicted,
    /// The field of the plane from which the `Predicted` plane is predicted.
    Reference,
    /// The field of the plane with the lowest rank.
    First,
    /// The field of the first plane that is predicted from plane 0.
    FromZero,
}

/// A part of a JPEG or JPEG-LS stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum StreamPart {
    /// The first segment with this marker code, before the data.
    Marker(u8),
    /// The frame header: marker code c0 or f7.
    Frame,
    /// The rest of the stream, starting at the scan header.
    Scan,
    /// The data after the scan header, without EOI.
    Data,
}

/// A position in a field, from which the place extends to the end of the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Offset {
    Forward(usize),
    Back(usize),
    /// Counted backward from the end, in texels of the last block.
    Texels(usize),
    /// Counted backward from the end, in rows of texels.
    Rows(usize),
    Half,
}

/// Names of fields, separated by `|`.
const NAMES: &str = "file|header|payload|version|format|width|height|scale|bias|count|count keyword|table|matrix|indices|\
    coefficients|colors|blue coefficients|parameter|transforms|motion x|motion y|order|references|compressed sizes|side sizes|\
    plane|side information";

impl FromStr for DamagePlace {
    type Err = Error;

    fn from_str(text: &str) -> Result<DamagePlace> {
        let unknown = |kind| Error::unknown(kind, text);
        let offset_start = text.rfind(['+', '-', '/']).unwrap_or(text.len());
        let offset = Offset::parse(&text[offset_start..]);
        let path = &text[..offset.map_or(text.len(), |_| offset_start)];
        let (mut field, mut segment, mut which) = (path, None, Selector::Nth(0));
        if let Some((before, part)) = path.split_once('.') {
            field = before;
            segment = Some(StreamPart::parse(part).ok_or_else(|| unknown("part in the location"))?);
        }
        if let Some((before, number)) = field.strip_suffix(']').and_then(|it| it.split_once('[')) {
            field = before;
            which = Selector::parse(number).ok_or_else(|| unknown("number in the location"))?;
        }
        if NAMES.split('|').all(|name| name != field) {
            return Err(unknown("field in the location"));
        }
        Ok(DamagePlace {
            name: field.to_owned(),
            which,
            segment,
            offset: offset.unwrap_or(Offset::Forward(0)),
        })
    }
}

impl TryFrom<String> for DamagePlace {
    type Error = Error;

    fn try_from(text: String) -> Result<DamagePlace> {
        text.parse()
    }
}

impl Offset {
    fn parse(text: &str) -> Option<Offset> {
        let (sign, number) = (text.get(..1)?, text.get(1..)?);
        Some(match (sign, number.split_once(' ')) {
            ("+", None) => Offset::Forward(number.parse().ok()?),
            ("-", None) => Offset::Back(number.parse().ok()?),
            ("-", Some((number, "texel"))) => Offset::Texels(number.parse().ok()?),
            ("-", Some((number, "row"))) => Offset::Rows(number.parse().ok()?),
            ("/", None) if number == "2" => Offset::Half,
            _ => return None,
        })
    }
}

impl StreamPart {
    fn parse(name: &str) -> Option<StreamPart> {
        Some(match name {
            "frame" => StreamPart::Frame,
            "scan" => StreamPart::Scan,
            "data" => StreamPart::Data,
            _ => StreamPart::Marker(u8::from_str_radix(name, 16).ok()?),
        })
    }

    fn range(self, stream: &[u8]) -> Option<Range<usize>> {
        let found = match self {
            StreamPart::Marker(code) => segment(stream, code)?,
            StreamPart::Frame => segment(stream, 0xc0).or_else(|| segment(stream, 0xf7))?,
            StreamPart::Scan => segment(stream, 0xda)?.start..stream.len(),
            StreamPart::Data => segment(stream, 0xda)?.end..stream.len().checked_sub(2)?,
        };
        (found.start <= found.end).then_some(found)
    }
}

/// Returns the first segment with this marker code before the data of a stream.
pub fn segment(stream: &[u8], code: u8) -> Option<Range<usize>> {
    let mut at = 2;
    loop {
        let &[_, found, high, low] = stream.get(at..at + 4)? else {
            return None;
        };
        let end = at + 2 + usize::from(high) * 256 + usize::from(low);
        match found {
            _ if found == code => return (end <= stream.len()).then_some(at..end),
            0xda => return None,
            _ => at = end,
        }
    }
}

impl Selector {
    fn parse(text: &str) -> Option<Selector> {
        Some(match text {
            "last" => Selector::Last,
            "all" => Selector::All,
            "predicted" => Selector::Predicted,
            "reference" => Selector::Reference,
            "first" => Selector::First,
            "from-0" => Selector::FromZero,
            _ => Selector::Nth(text.parse().ok()?),
        })
    }

    fn plane(self, model: &Model) -> Option<usize> {
        let plan = &model.compressed.as_ref()?.plan;
        let by_rank = plan.decoding_order();
        let is_predicted = |plane: &&usize| plan.reference(**plane).is_some();
        let predicted = by_rank.iter().rev().find(is_predicted).copied();
        match self {
            Selector::Predicted => predicted,
            Selector::Reference => plan.reference(predicted?),
            Selector::First => by_rank.first().copied(),
            Selector::FromZero => (1..by_rank.len()).find(|&p| plan.reference(p) == Some(0)),
            Selector::Nth(_) | Selector::Last | Selector::All => None,
        }
    }
}

/// A range of bytes in a file, and the index of its field among all fields.
#[derive(Clone, Debug)]
pub struct Spot {
    pub field: usize,
    pub range: Range<usize>,
}

impl Spot {
    /// Creates a range that belongs to no field.
    pub fn outside(range: Range<usize>) -> Spot {
        Spot {
            field: usize::MAX,
            range,
        }
    }
}

/// A file whose places can be looked up by name.
pub struct NamedPlaces<'a> {
    pub written: &'a GeneratedFile,
    pub model: &'a Model,
}

impl NamedPlaces<'_> {
    /// Returns the range of a place, which must occur exactly once.
    pub fn spot(&self, place: &DamagePlace) -> Result<Spot> {
        let spots = self.spots(place)?;
        let [spot] = &spots[..] else {
            let reason = format!("several parts of the file match {}", place.name);
            return Err(Error::NotApplicable(reason.into()));
        };
        Ok(spot.clone())
    }

    /// Returns all ranges of a place.
    pub fn spots(&self, place: &DamagePlace) -> Result<Vec<Spot>> {
        let missing =
            || Error::NotApplicable(format!("the file has no matching {}", place.name).into());
        let spots = self.fields(place).ok_or_else(missing)?.into_iter();
        let part = |spot: Spot| {
            let range = self.part(place, spot.range)?;
            Some(Spot { range, ..spot })
        };
        spots.map(part).collect::<Option<_>>().ok_or_else(missing)
    }

    fn fields(&self, place: &DamagePlace) -> Option<Vec<Spot>> {
        let (payload, end) = (self.written.payload, self.written.bytes.len());
        let named = self.fields_named(&place.name);
        let range = match place.name.as_str() {
            "file" => 0..end,
            "header" => 0..payload,
            "payload" => payload..end,
            _ => {
                let spot = match place.which {
                    Selector::All => return Some(named),
                    Selector::Last => named.last()?,
                    Selector::Nth(nth) => named.get(nth)?,
                    which => named.get(which.plane(self.model)?)?,
                };
                return Some(vec![spot.clone()]);
            }
        };
        Some(vec![Spot::outside(range)])
    }

    /// Returns the fields with this name, in file order.
    pub fn fields_named(&self, name: &str) -> Vec<Spot> {
        let fields = self.written.fields.iter().enumerate();
        let named = fields.filter(|(_, field)| field.name == name);
        let spot = |(field, found): (usize, &ptm::Field)| Spot {
            field,
            range: found.range.clone(),
        };
        named.map(spot).collect()
    }

    /// Returns the part of a field that a place selects.
    fn part(
        &self,
        place: &DamagePlace,
        Range { mut start, mut end }: Range<usize>,
    ) -> Option<Range<usize>> {
        if let Some(segment) = place.segment {
            let range = segment.range(&self.written.bytes[start..end])?;
            (start, end) = (start + range.start, start + range.end);
        }
        let texel = || {
            let block = self.written.fields.last()?.range.len();
            block.checked_div(self.model.size.texels())
        };
        let back = |length: usize| end.checked_sub(length);
        let start = match place.offset {
            Offset::Forward(length) => Some(start + length),
            Offset::Back(length) => back(length),
            Offset::Texels(count) => back(count * texel()?),
            Offset::Rows(count) => back(count * texel()? * self.model.size.width as usize),
            Offset::Half => Some(start.midpoint(end)),
        }
        .filter(|at| (start..=end).contains(at))?;
        Some(start..end)
    }

    /// Returns the text of a range.
    pub fn text(&self, range: &Range<usize>) -> String {
        String::from_utf8_lossy(&self.written.bytes[range.clone()]).into_owned()
    }

    /// Returns the value of the placeholder `{name}` in the new content of a range.
    pub fn fill(&self, name: &str, at: &Range<usize>) -> Result<String> {
        let plane = |which: Selector| which.plane(self.model).map(|plane| plane.to_string());
        let value = match name {
            "" => Some(self.text(at)),
            ":lower" => Some(self.text(at).to_lowercase()),
            ":hex" => {
                let number: Option<u64> = self.text(at).parse().ok();
                number.map(|number| format!("{number:x}"))
            }
            "planes" => Some(self.model.format.channels().to_string()),
            "predicted" => plane(Selector::Predicted),
            "first" => plane(Selector::First),
            _ => Some(self.text(&self.spot(&name.parse()?)?.range)),
        };
        value.ok_or_else(|| Error::NotApplicable(format!("the file has no {{{name}}}").into()))
    }
}
