import pytest

from assetpipe.errors import UsageError
from assetpipe.pipeline.shards import Shard


@pytest.mark.parametrize("count", [1, 2, 3, 7, 20])
def test_shards_are_disjoint_and_cover_everything(count: int) -> None:
    items = list(range(13))
    parts = [Shard(n + 1, count).of(items) for n in range(count)]
    assert sorted(item for part in parts for item in part) == items


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/2", "1/2/3", ""])
def test_wrong_shards_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="shard"):
        Shard.parse(text)


def test_reads_its_form() -> None:
    assert Shard.parse("2/8") == Shard(2, 8)
    assert Shard.parse(None) == Shard(1, 1)
