"""testXpert series, written by the encoder of those who decoded the format: an unlike hand."""

import gzip

import numpy as np
import pytest

import instron

encoder = pytest.importorskip("zs2decode.encoder")
SI = {"displacement": "m", "force": "N", "time": "s"}
T = np.arange(40) * 0.1
X = np.round(T * 2.5e-4, 7)
F = 3 * np.sin(np.arange(40) / 9) ** 2


def section(name, *inside):
    return [[None, name, "DD", ""], *(c for part in inside for c in part), [None, "", "end", []]]


def channel_names(names):
    entries = [section(f"Elem{i}", [[None, "ID", "22", key]],
                       section("Name", [[None, "Text", "AA", name]]))
               for i, (key, name) in enumerate(names.items())]  # fmt: skip
    manager = section("ChannelManager", section("ChannelManager", *entries))
    return section("SeriesDef", section("TestTaskDefs", section("Elem0", manager)))


def recording(columns, kind):
    channels = [section(f"Elem{i}", [[None, "TrsChannelId", "22", key],
                                     [None, "DataArray", kind, [float(v) for v in column]]])
                for i, (key, column) in enumerate(columns.items())]  # fmt: skip
    return section("SingleGroupDataBlock", [[None, "IndexTimeChannel", "22", 0]],
                   section("DataChannels", *channels))  # fmt: skip


def write(path, names, recordings, kind="EE05"):
    samples = [section(f"Elem{i}", section("RealTimeCapture", section("Trs", recording(r, kind))))
               for i, r in enumerate(recordings)]  # fmt: skip
    series = section("Series", section("SeriesElements", *samples))
    whole = section("Document", section("Body", section("batch", channel_names(names), series)))
    stream = encoder.make_datastream(encoder.make_raw_chunks(whole))
    encoder.save_zs2(str(path), stream)
    return path


NAMES = {7: "Pr\u00fcfzeit", 3: "Traversenweg", 12: "Standardkraft", 40: "Traversengeschwindigkeit"}
COLUMNS = {7: T, 3: X, 12: F, 40: np.full(40, 2.5e-4)}


@pytest.mark.parametrize(("kind", "rtol"), [("EE05", 1e-12), ("EE04", 1e-6)])
def test_specimens_of_a_series(tmp_path, kind, rtol):
    second = {key: column[:25] * 0.5 for key, column in COLUMNS.items()}
    path = write(tmp_path / "nylon.zs2", NAMES, [COLUMNS, second], kind)
    logs = instron.read(path, units=SI)
    assert [log.attrs["specimen"] for log in logs] == ["specimen 1", "specimen 2"]
    for log, factor in zip(logs, (1.0, 0.5), strict=True):
        n = len(log)
        np.testing.assert_allclose(log["time"], T[:n] * factor, rtol=rtol, atol=1e-7)
        np.testing.assert_allclose(log["displacement"], X[:n] * factor, rtol=rtol, atol=1e-10)
        np.testing.assert_allclose(log["force"], F[:n] * factor, rtol=rtol, atol=1e-7)
        assert log.attrs["warnings"] == []
        assert log.attrs["dialect"]["encoding"] == "testXpert"


def test_units_are_asked_for(tmp_path):
    path = write(tmp_path / "nylon.zs2", NAMES, [COLUMNS])
    with pytest.raises(
        instron.Unreadable, match=r"nylon\.zs2: .*--units displacement=\.\.\.,force="
    ):
        instron.read(path)
    (log,) = instron.read(path, units=SI | {"displacement": "mm"})
    np.testing.assert_allclose(log["displacement"], X * 1e-3, atol=1e-12)


def test_what_cannot_be_read_is_refused_by_name(tmp_path):
    path = write(tmp_path / "cut.zs2", NAMES, [COLUMNS])
    path.write_bytes(gzip.compress(gzip.decompress(path.read_bytes())[:-300]))
    with pytest.raises(instron.Unreadable, match=r"cut\.zs2"):
        instron.read(path, units=SI)
    planned = {key: [] for key in COLUMNS}
    for number, recordings in enumerate(([], [planned])):
        path = write(tmp_path / f"none{number}.zs2", NAMES, recordings)
        with pytest.raises(instron.Unreadable, match="no recorded specimen"):
            instron.read(path, units=SI)
    assert len(instron.read(write(tmp_path / "one.zs2", NAMES, [planned, COLUMNS]), units=SI)) == 1
    with pytest.raises(instron.Unreadable, match=r"specimen 1: channels of \[40, 39\]|\[39, 40\]"):
        instron.read(write(tmp_path / "odd.zs2", NAMES, [COLUMNS | {12: F[:39]}]), units=SI)
    with pytest.raises(instron.Unreadable, match="no force"):
        instron.read(write(tmp_path / "dry.zs2", NAMES, [{7: T, 3: X}]), units=SI)
