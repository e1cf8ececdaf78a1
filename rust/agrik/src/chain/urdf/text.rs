//! Words for messages: quoted values, listings, the nearest of many names.

/// How many names a message lists before it only counts the rest.
const LISTED: usize = 12;
/// How much of a long value a message shows.
const SHOWN: usize = 60;
/// Letters of the longest name that another is suggested for: comparing takes their square.
const COMPARED: usize = 64;

/// A value between quotes, on one line, shortened where it is long.
pub(super) fn quoted(value: &str) -> String {
    let mut shown = String::new();
    for letter in value.chars().take(SHOWN) {
        if letter.is_control() {
            shown.extend(letter.escape_default());
        } else {
            shown.push(letter);
        }
    }
    let more = if value.chars().nth(SHOWN).is_some() { "..." } else { "" };
    format!("'{shown}{more}'")
}

/// `'a', 'b', 'c' and 7 more`.
pub(super) fn listing<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(quoted).collect();
    let head = names[..names.len().min(LISTED)].join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => head,
        more => format!("{head} and {more} more"),
    }
}

/// What to say about a name that is not known: `; did you mean 'x'?`, or nothing where no
/// name is near.
pub(super) fn suggestion<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let wanted = name.to_lowercase();
    // A third of the letters, but never all of them.
    let letters = wanted.chars().count();
    if letters > COMPARED {
        return String::new();
    }
    let limit = letters.div_ceil(3).min(letters.saturating_sub(1));
    known
        .into_iter()
        .filter(|candidate| candidate.chars().count().abs_diff(letters) <= limit)
        .map(|candidate| (distance(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, _)| *distance)
        .map_or_else(String::new, |(_, candidate)| format!("; did you mean {}?", quoted(candidate)))
}

/// Levenshtein distance: how many letters to insert, remove or replace.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_of_words() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("same", "same"), 0);
    }

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["base_link", "tool0"];
        assert_eq!(suggestion("bas_link", known), "; did you mean 'base_link'?");
        assert_eq!(suggestion("camera", known), "");
        assert_eq!(suggestion("k", ["j"]), "");
        let long = "k".repeat(COMPARED + 1);
        assert_eq!(suggestion(&long, [long.as_str()]), "");
    }

    #[test]
    fn long_lists_and_values_are_cut() {
        let names: Vec<String> = (0..15).map(|i| format!("l{i}")).collect();
        assert!(listing(names.iter().map(String::as_str)).ends_with("'l11' and 3 more"));
        assert_eq!(listing([]), "");
        assert!(quoted(&"é".repeat(100)).chars().count() < 70);
        assert_eq!(quoted("é 'a'\n"), "'é 'a'\\n'");
    }
}
