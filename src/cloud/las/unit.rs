//! The unit of length that a LAS file states, by GeoTIFF keys or by well-known text. It is named, never applied.

use crate::text::short_name;
use las::Header;
use las::crs::GeoTiffData;

/// GeoTIFF key of the unit of the horizontal coordinates.
const PROJ_LINEAR_UNITS: u16 = 3076;

/// The unit's name, where the file states one.
pub(super) fn unit_of(header: &Header) -> Option<String> {
    let wkt = header.get_wkt_crs_bytes().map(String::from_utf8_lossy);
    if let Some(unit) = wkt.as_deref().and_then(unit_of_wkt) {
        return Some(unit);
    }
    let keys = header.get_geotiff_crs().ok().flatten()?;
    keys.entries
        .iter()
        .find_map(|entry| match (entry.id, &entry.data) {
            (PROJ_LINEAR_UNITS, GeoTiffData::U16(code)) => Some(epsg_unit(*code)),
            _ => None,
        })
}

fn epsg_unit(code: u16) -> String {
    match code {
        9001 => "metre".to_owned(),
        9002 => "foot".to_owned(),
        9003 => "US survey foot".to_owned(),
        9036 => "kilometre".to_owned(),
        other => format!("EPSG unit {other}"),
    }
}

/// The first unit that belongs to a projected system itself or its axes, not to its ellipsoid, angles or heights.
fn unit_of_wkt(wkt: &str) -> Option<String> {
    let mut open: Vec<String> = Vec::new();
    let mut keyword = String::new();
    let mut rest = wkt.chars();
    while let Some(c) = rest.next() {
        match c {
            '[' | '(' => open.push(std::mem::take(&mut keyword)),
            ']' | ')' => {
                open.pop();
                keyword.clear();
            }
            '"' => {
                let text: String = rest.by_ref().take_while(|&c| c != '"').collect();
                let path: Vec<&str> = open.iter().map(String::as_str).collect();
                if let [outer @ .., "UNIT" | "LENGTHUNIT"] = path.as_slice()
                    && is_projected(outer)
                {
                    return Some(short_name(&text));
                }
            }
            c if c.is_ascii_alphabetic() || c == '_' => keyword.push(c.to_ascii_uppercase()),
            _ => keyword.clear(),
        }
    }
    None
}

fn is_projected(path: &[&str]) -> bool {
    let system = match path {
        [.., system, "AXIS"] | [.., system] => system,
        [] => return false,
    };
    matches!(
        *system,
        "PROJCS" | "PROJCRS" | "PROJECTEDCRS" | "GEOCCS" | "LOCAL_CS" | "ENGCRS" | "ENGINEERINGCRS"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_is_that_of_the_projection_not_of_its_ellipsoid_or_heights() {
        let one = r#"COMPD_CS["a",PROJCS["NAD83",GEOGCS["g",DATUM["d",SPHEROID["s",6378137,298]],UNIT["degree",0.01]],
            PROJECTION["Lambert"],PARAMETER["p",1],UNIT["foot",0.3048],AXIS["E",EAST]],VERT_CS["v",UNIT["metre",1]]]"#;
        assert_eq!(unit_of_wkt(one).as_deref(), Some("foot"));
        let two = r#"PROJCRS["x",BASEGEOGCRS["b",DATUM["d",ELLIPSOID["e",6378137,298,LENGTHUNIT["metre",1]]]],
            CS[Cartesian,2],AXIS["(E)",east,LENGTHUNIT["US survey foot",0.3048006]]]"#;
        assert_eq!(unit_of_wkt(two).as_deref(), Some("US survey foot"));
        assert_eq!(
            unit_of_wkt(r#"GEOGCS["WGS 84",UNIT["degree",0.0174]]"#),
            None,
            "degrees are no length"
        );
        assert_eq!(unit_of_wkt("PROJCS[\"never closed"), None);
    }
}
