//! A cache of decoded streams. Hundreds of mistakes affect only later steps, so the same streams are decoded repeatedly.

use std::sync::Mutex;

use foldhash::HashMap;
use ptm::decode::planes;
use ptm::error::Result;
use ptm::parts::PlaneStream;
use ptm::{Coding, Size};

/// Size of the cached streams and samples, in bytes, beyond which the cache is cleared.
const MAX_CACHED_BYTES: usize = 128 << 20;

type CachedSamples = HashMap<Box<[u8]>, Box<[u8]>>;

/// Total size in bytes, and the decoded samples by coding standard, image size and stream. The cache is global because the
/// decisions of a [`Reading`](ptm::Reading) are plain functions.
static DECODED_STREAMS: Mutex<Option<(usize, HashMap<(Coding, Size), CachedSamples>)>> =
    Mutex::new(None);

/// Decodes a stream as the reference does, but decodes equal streams only once.
pub fn decode_stream_cached(stream: &PlaneStream) -> Result<Vec<u8>> {
    let (coding, size) = (stream.coding, stream.size);
    let lookup = |cache: &Option<(usize, HashMap<_, CachedSamples>)>| {
        let (_, decoded) = cache.as_ref()?;
        let same_size = decoded.get(&(coding, size))?;
        Some(same_size.get(stream.bytes)?.to_vec())
    };
    if let Some(samples) = lookup(&DECODED_STREAMS.lock().expect("no worker panics")) {
        return Ok(samples);
    }
    let samples = planes::decode_stream(stream)?;
    let mut cache = DECODED_STREAMS.lock().expect("no worker panics");
    let (bytes, decoded) = cache.get_or_insert_default();
    if *bytes > MAX_CACHED_BYTES {
        (*bytes, *decoded) = Default::default();
    }
    *bytes += samples.len() + stream.bytes.len();
    let same_size = decoded.entry((coding, size)).or_default();
    same_size.insert(stream.bytes.into(), samples.clone().into());
    Ok(samples)
}
