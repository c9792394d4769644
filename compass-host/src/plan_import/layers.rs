//! What the layers of a drawing are: by patterns that the user gives, and by a table of names in use.

use std::fmt;
use std::str::FromStr;

/// What the layer of a drawing shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LayerRole {
    /// Walls of which nothing more is known.
    Wall,
    /// What bears the building and stands first: outer walls, columns, concrete.
    Structure,
    /// Walls of the fit-out.
    Partition,
    /// Windows, curtain walls.
    Glazing,
    /// Door leaves and their arcs: open, so not part of the plan.
    Door,
    /// Not part of the plan.
    Ignored,
}

impl LayerRole {
    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wall => "wall",
            Self::Structure => "structure",
            Self::Partition => "partition",
            Self::Glazing => "glazing",
            Self::Door => "door",
            Self::Ignored => "ignored",
        }
    }

    /// Whether it is wall of any kind.
    #[must_use]
    pub const fn is_wall(self) -> bool {
        matches!(self, Self::Wall | Self::Structure | Self::Partition)
    }

    /// Whether it is part of the plan: wall or glazing.
    #[must_use]
    pub const fn is_plan(self) -> bool {
        self.is_wall() || matches!(self, Self::Glazing)
    }
}

/// A pattern of layer names, without case: `*` stands for any letters, `?` for one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LayerPattern {
    letters: Vec<char>,
}

/// The pattern is empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a pattern of layer names is empty")]
pub struct EmptyPattern;

impl FromStr for LayerPattern {
    type Err = EmptyPattern;

    fn from_str(text: &str) -> Result<Self, EmptyPattern> {
        let letters: Vec<char> = folded(text.trim()).chars().collect();
        if letters.is_empty() { Err(EmptyPattern) } else { Ok(Self { letters }) }
    }
}

impl fmt::Display for LayerPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.letters.iter().try_for_each(|letter| write!(f, "{letter}"))
    }
}

impl LayerPattern {
    fn matches(&self, name: &[char]) -> bool {
        // Linear in time but for the last star, which is tried again one letter further.
        let (mut at, mut read) = (0, 0);
        let mut star = None;
        while read < name.len() {
            match self.letters.get(at) {
                Some('*') => {
                    star = Some((at, read));
                    at += 1;
                }
                Some(&letter) if letter == '?' || letter == name[read] => {
                    at += 1;
                    read += 1;
                }
                _ => match &mut star {
                    Some((back, from)) => {
                        *from += 1;
                        (at, read) = (*back + 1, *from);
                    }
                    None => return false,
                },
            }
        }
        self.letters[at..].iter().all(|letter| *letter == '*')
    }

    /// Letters that must be there: the more, the more exact the pattern.
    fn exactness(&self) -> usize {
        self.letters.iter().filter(|letter| **letter != '*').count()
    }
}

/// Which layer is what: patterns before a table of names in use.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LayerRoles {
    /// Patterns and what they say. Of several that match, the one with the most letters counts.
    pub told: Vec<(LayerPattern, LayerRole)>,
}

impl LayerRoles {
    /// The role of a layer; `None` where neither the patterns nor the table know the name.
    #[must_use]
    pub fn of(&self, name: &str) -> Option<LayerRole> {
        let letters: Vec<char> = folded(name).chars().collect();
        let told = self.told.iter().filter(|(pattern, _)| pattern.matches(&letters));
        told.max_by_key(|(pattern, _)| pattern.exactness()).map(|(_, role)| *role).or_else(|| by_name(name))
    }

    /// Whether a pattern says which layers are walls.
    pub(super) fn tells_walls(&self) -> bool {
        self.told.iter().any(|(_, role)| role.is_wall())
    }
}

/// Words of layer names: English (AIA and NCS short forms too), German, French, Spanish, Italian, Dutch. A word stands
/// at the start of a part of the name; one of up to four letters, or after `=`, is all of it or its plural; one after `~`
/// stands at its end, as in German compounds; `_` is a blank. The first line with a word of the name counts.
const TABLE: [(LayerRole, &str); 7] = [
    (
        LayerRole::Ignored,
        "dim anno demo demolition abbruch center centre cntr text note iden symb furn furniture dimension \
         annotation mobel moebel mobilier mobili muebles meubel meubilair equip sanit plumb hvac elec \
         lighting grid axis achse bemass masse beschrift schrift texte texto testo cota cote kote quote \
         quota maat area room raum space stair strs treppe escalier escalera scala scale trap ceil clng \
         decke roof dach defpoints viewport vport title ttlb floor_pattern hatch_only patt prht hdln ovhd \
         landscape tree slab beam unterzug fundament foundation railing gelander ~bemassung ~beschriftung \
         ~mobel ~moebel ~dachfenster ~treppe ~achsen ~raumstempel",
    ),
    (
        LayerRole::Glazing,
        "glaz glass glas window wind wndw fenetre vitrage vitre ventana vidrio finestra finestre vetro \
         vetrata raam ramen kozijn beglazing curtain verglas fassade facade fachada facciata gevel ~fenster \
         ~verglasung ~glaswand ~glaswande ~fassade ~fassaden",
    ),
    (LayerRole::Door, "door tuer tur tueren turen =porte puerta =porta deur deuren ~turen ~tueren"),
    (
        LayerRole::Structure,
        "col column ext pillar pier struct bearing concrete conc shear core extr exterior external outer \
         stutze stuetze saule saeule pfeiler rohbau beton =aussen aussenw ausenw tragend poteau porteur \
         exterieur pilar columna estructura colonna colonne pilastro struttura esterno esterni portante \
         kolom buitenm buitenw draagm dragend constructie ~stutzen ~stuetzen ~rohbau ~beton ~aussenwand \
         ~aussenwande ~aussenwaende ~buitenmuur ~buitenmuren",
    ),
    (
        LayerRole::Partition,
        "partition partn prtn part drywall gypsum stud fitout fit_out ausbau trockenbau leichtbau trennw \
         vormauer vorsatz gipskarton doublage nichttragend cloison tabique tabiqueria tramezz tramezzo \
         cartongesso scheidingsw ~trockenbau ~trennwand ~trennwande ~vormauerung ~vormauerungen \
         ~leichtbauwand",
    ),
    (
        LayerRole::Wall,
        "wall walls wand wande waende mauer mauerwerk innenw mur murs muro muros pared paredes muri parete \
         pareti muur muren wanden maconnerie muratura brick masonry ~wande ~waende ~wand ~mauerwerk ~walls",
    ),
    (LayerRole::Ignored, "hatch schraffur ~schraffur hachure tratteggio rayado arcering"),
];

/// The role of a layer by the table of names in use.
fn by_name(name: &str) -> Option<LayerRole> {
    let name = folded(name);
    let parts: Vec<&str> =
        name.split(|letter: char| !letter.is_alphabetic()).filter(|part| !part.is_empty()).collect();
    let joined = parts.join(" ");
    let is_part = |word: &str| parts.iter().any(|part| *part == word || part.strip_suffix('s') == Some(word));
    let has = |word: &str| match word.split_at(word.len().min(1)) {
        ("~", end) => parts.iter().any(|part| part.ends_with(end)),
        // "porte" is no "porteur".
        ("=", whole) => is_part(whole),
        _ if word.contains('_') => joined.contains(&word.replace('_', " ")),
        // "tur" is no "turning", "dim" no "dimmer".
        _ if word.len() <= 4 => is_part(word),
        _ => parts.iter().any(|part| part.starts_with(word)),
    };
    TABLE.iter().find(|(_, words)| words.split_whitespace().any(has)).map(|(role, _)| *role)
}

/// Lower case, without accents.
fn folded(name: &str) -> String {
    let plain = |letter: char| match letter {
        'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' => 'a',
        'ç' => 'c',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ñ' => 'n',
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' => 'o',
        'ù' | 'ú' | 'û' | 'ü' => 'u',
        other => other,
    };
    // Accents may come as marks of their own, after the letter.
    let mark = |letter: &char| !('\u{300}'..='\u{36f}').contains(letter);
    name.chars().flat_map(char::to_lowercase).filter(mark).map(plain).collect::<String>().replace('ß', "ss")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn role(name: &str) -> Option<LayerRole> {
        LayerRoles::default().of(name)
    }

    #[test]
    fn names_in_use_are_known() {
        use LayerRole as R;
        for (wanted, names) in [
            (
                R::Wall,
                &[
                    "A-WALL",
                    "A-WALL-FULL",
                    "Walls",
                    "015 Innenwände",
                    "Innenwa\u{308}nde",
                    "MURS",
                    "Muro",
                    "Pareti",
                    "Wanden",
                    "paredes",
                ][..],
            ),
            (
                R::Structure,
                &[
                    "S-COLS",
                    "S-COL",
                    "MURS_EXT",
                    "Stahlbeton",
                    "Wand aussen",
                    "A-COLS",
                    "A-WALL-EXTR",
                    "010 Aussenwände",
                    "Außenwände",
                    "020 Stützen",
                    "ROHBAU",
                    "2_Rohbau_Beton",
                    "Murs porteurs",
                    "Muri esterni",
                    "Columns",
                    "Buitenmuren",
                    "Wall External",
                ],
            ),
            (
                R::Partition,
                &[
                    "016 Trennwände",
                    "AUSBAU",
                    "Trockenbau",
                    "A-WALL-PARTN",
                    "A-WALL-PRTN",
                    "019 Vormauerungen",
                    "Cloisons",
                    "Partition walls",
                    "Tabiques",
                ],
            ),
            (
                R::Glazing,
                &[
                    "A-GLAZ",
                    "A-GLAZ-CURT",
                    "010 Fenster",
                    "Fassade",
                    "012 Vorhangfassade",
                    "Fenêtres",
                    "Ventanas",
                    "Finestre",
                    "Ramen",
                    "window regular",
                    "Glass wall",
                ],
            ),
            (
                R::Door,
                &["A-DOOR", "010 Türen", "Tueren", "Portes", "Puertas", "Porte", "Deuren", "INNENTÜREN"],
            ),
            (
                R::Ignored,
                &[
                    "A-WALL-DIMS",
                    "A-ANNO-TEXT",
                    "Bemaßung",
                    "A-FURN",
                    "Möbel",
                    "A-FLOR-STRS",
                    "Defpoints",
                    "A-WALL-PATT",
                    "A-WALL-DEMO",
                    "Wand-Schraffur-Text",
                    "HATCH",
                ],
            ),
        ] {
            for name in names {
                assert_eq!(role(name), Some(wanted), "{name}");
            }
        }
        for name in ["0", "Layer1", "XREF$0$misc", "Turning circle", "Dimmer"] {
            assert_eq!(role(name), None, "{name}");
        }
    }

    #[test]
    fn the_most_exact_pattern_counts() {
        let told = |text: &str, role| (text.parse().unwrap(), role);
        let roles = LayerRoles {
            told: vec![
                told("A-*", LayerRole::Wall),
                told("a-misc*", LayerRole::Ignored),
                told("?-GLAS*neu", LayerRole::Glazing),
                told("*türen*", LayerRole::Wall),
            ],
        };
        for (name, wanted) in [
            ("A-FOO", LayerRole::Wall),
            ("a-MISC-3", LayerRole::Ignored),
            ("B-Glaswand Neu", LayerRole::Glazing),
            ("A-FURN", LayerRole::Wall),
            ("Innenturen", LayerRole::Wall),
            ("S-COLS", LayerRole::Structure),
        ] {
            assert_eq!(roles.of(name), Some(wanted), "{name}");
        }
        assert_eq!(" ".parse::<LayerPattern>(), Err(EmptyPattern));
    }

    #[test]
    fn patterns_of_many_stars_end() {
        let pattern: LayerPattern = "*a*a*a*a*a*a*a*a*b".parse().unwrap();
        let name: Vec<char> = "a".repeat(5000).chars().collect();
        assert!(!pattern.matches(&name));
        assert!(LayerPattern::from_str("a*").unwrap().matches(&['a']));
        assert!(!LayerPattern::from_str("a?").unwrap().matches(&['a']));
    }
}
