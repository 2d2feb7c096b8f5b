"""XML with byte offsets: every element is found where it stands."""

from pathlib import Path
from time import process_time
from xml.sax.saxutils import escape, quoteattr

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from assetpipe.errors import InputError, LimitError
from assetpipe.robot.markup import Element, read_markup

FILE = Path("a.urdf")

names = st.from_regex(r"[a-z][a-z0-9_:-]{0,5}", fullmatch=True).filter(
    lambda n: not n.startswith("xml") and ":" not in n
)
texts = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"), max_size=6
)
attributes = st.dictionaries(names, texts, max_size=3)


@st.composite
def elements(draw: st.DrawFn, depth: int = 3) -> str:
    tag = draw(names)
    space = draw(st.sampled_from([" ", "\n ", "\t", "\r\n"]))
    written = "".join(
        f"{space}{name}{draw(st.sampled_from(['=', ' = ']))}{quoteattr(value)}"
        for name, value in draw(attributes).items()
    )
    if draw(st.booleans()) or depth == 0:
        return draw(st.sampled_from([f"<{tag}{written}/>", f"<{tag}{written} ></{tag} >"]))
    inside = draw(
        st.lists(
            st.one_of(
                elements(depth=depth - 1),
                texts.map(escape),
                st.just("<!-- <a b='c'> -->"),
                st.just("<![CDATA[<no element/>]]>"),
                st.just("<?pi <a/> ?>"),
            ),
            max_size=4,
        )
    )
    return f"<{tag}{written}>{''.join(inside)}</{tag}>"


@given(elements())
def test_every_element_is_found_at_its_bytes(text: str) -> None:
    source = text.encode()
    markup = read_markup(source, FILE)
    assert markup.text == source
    oracle = [e for e in etree.fromstring(source).iter() if isinstance(e.tag, str)]
    found = list(markup.root.walk())
    assert [e.tag for e in found] == [e.tag for e in oracle]
    assert [e.attributes for e in found] == [dict(e.attrib) for e in oracle]
    for element, other in zip(found, oracle, strict=True):
        alone = etree.fromstring(markup.of(element))
        other.tail = None
        assert etree.tostring(alone, method="c14n") == etree.tostring(other, method="c14n")


def test_lines_children_and_text() -> None:
    markup = read_markup(b"<a>\n <b x='1'>t</b>\n <c/>\n <b/>\n</a>", FILE)
    assert [e.line for e in markup.root.walk()] == [1, 2, 3, 4]
    assert [e.attributes for e in markup.root.all("b")] == [{"x": "1"}, {}]
    first = markup.root.first("b")
    assert isinstance(first, Element)
    assert first.text == "t"
    assert markup.root.first("none") is None


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "iso-8859-1", "shift_jis", "utf-32"])
def test_encodings(encoding: str) -> None:
    label = encoding.replace("-sig", "")
    word = "日本" if encoding != "iso-8859-1" else "Größe"
    source = f"<?xml version='1.0' encoding='{label}'?><a x='{word}'/>".encode(encoding)
    markup = read_markup(source, FILE)
    assert markup.root.attributes == {"x": word}


@pytest.mark.parametrize(
    ("source", "line", "message"),
    [
        (b'<?xml version="0.0"?><a><b/></a>', 1, "XML version '0.0'"),
        (b'\n\n <?xml version="1.0"?>\n<a><b/></a>', 3, "declaration is not at the very beginning"),
        (b'<!-- x -->\n<?xml version="1.0"?>\n<a><b/></a>', 2, "declaration is not at"),
        (b"<a><b/></a>\n hello & bye \0", 2, "text after the end"),
        (b"<a>\n<!-- -- --- -->\n<b/></a>", 2, "'--' inside of a comment"),
        (b"<a>\n<!-- \xff -->\n<b/></a>", 2, "bytes that are not UTF-8"),
    ],
)
def test_slips_with_one_reading_are_told(source: bytes, line: int, message: str) -> None:
    markup = read_markup(source, FILE)
    assert markup.text == source
    assert markup.of(markup.root.children[0]) == b"<b/>"
    (slip,) = markup.slips
    assert slip.line == line
    assert message in slip.message


def test_several_slips_at_once() -> None:
    source = b'\n<?xml version="1.0"?>\n<a><!-- -- \xfe --><b/></a>\ntrailing'
    assert len(read_markup(source, FILE).slips) == 4


@pytest.mark.parametrize(
    ("source", "line"),
    [
        (b"<a>\n<b></a>", 2),
        (b"<a>\n<b x='1' x='2'/></a>", 2),
        (b"<a>\n<b x=1/></a>", 2),
        (b"<a/>\n<a/>", 2),
        (b"<a>\n&unknown;</a>", 2),
        (b"", 1),
        (b"<a>\n", 2),
        (b"<a x='\n<'/>", 2),
        (b"\x1f\x8b binary", 1),
    ],
)
def test_what_has_no_single_reading_is_an_error_with_its_line(source: bytes, line: int) -> None:
    with pytest.raises(InputError, match="not well-formed") as caught:
        read_markup(source, FILE)
    assert caught.value.location is not None
    assert caught.value.location.line == line


@pytest.mark.parametrize(
    "source",
    [
        b'<!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>',
        b'<!DOCTYPE a [<!ENTITY % p SYSTEM "http://h/x"> %p;]><a/>',
        b'\n<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>',
        '<!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>'.encode("utf-16"),
    ],
)
def test_entity_declarations_are_refused(source: bytes) -> None:
    with pytest.raises(InputError, match="entities may be bombs"):
        read_markup(source, FILE)


def test_entities_of_an_external_document_type_are_unknown() -> None:
    with pytest.raises(InputError, match="unknown entity '&x;'"):
        read_markup(b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a>&x;</a>', FILE)
    assert read_markup(b'<!DOCTYPE a SYSTEM "http://h/a.dtd"><a/>', FILE).root.tag == "a"


def test_depth_is_limited() -> None:
    with pytest.raises(LimitError):
        read_markup(b"<a>" * 100_000, FILE)


def test_beginnings_of_comments_without_end_take_no_time() -> None:
    clock = process_time()
    with pytest.raises(InputError):
        read_markup(b"<a>" + b"<!--" * 200_000, FILE)
    assert process_time() - clock < 3.0
