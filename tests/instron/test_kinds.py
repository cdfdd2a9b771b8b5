"""What machines save for themselves, by name: alone and in a folder."""

import pytest

import instron

OWN = [("a.is_tens", "Bluehill sample"), ("a.is_tcyclic", "Bluehill sample"),
       ("A.IS_COMP", "Bluehill sample"), ("a.im_tens", "Bluehill method"),
       ("a.id_tens", "Bluehill data"), ("a.zp2", "testXpert series")]  # fmt: skip
LOG = "Time (s),Extension (mm),Load (N)\n0,0,0.5\n1,1,1.5\n2,2,2.5\n"
CONTENTS = [b"<?xml version='1.0'?><Sample/>", "<?xml?><S/>".encode("utf-16"),
            bytes(range(256)), LOG.encode()]  # fmt: skip


@pytest.mark.parametrize(("name", "what"), OWN)
@pytest.mark.parametrize("content", CONTENTS)
def test_a_machines_own_file_is_named_with_how_to_export(tmp_path, name, what, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(instron.Unreadable, match=rf"{name}: a {what}.*: export the"):
        instron.read(tmp_path / name)


def test_a_folder_tells_exports_own_files_and_others(tmp_path):
    for name, _ in OWN:
        (tmp_path / name).write_bytes(CONTENTS[0])
    for name in ("run2.CSV", "run1.txt", ".hidden.csv", "notes.docx", "rig.toml"):
        (tmp_path / name).write_text(LOG)
    (tmp_path / "old.csv").mkdir()
    files, passed = instron.exports(tmp_path)
    assert [path.name for path in files] == ["run1.txt", "run2.CSV"]
    assert {path.name for path, _ in passed} == {name for name, _ in OWN} | {tmp_path.name}
    assert all("export" in why for path, why in passed if path != tmp_path)
    assert passed[-1][1].endswith("2 with another ending not looked at: notes.docx, rig.toml")


def test_a_folder_without_exports_is_refused_by_what_is_in_it(tmp_path):
    (tmp_path / "run1.is_tens").write_bytes(CONTENTS[0])
    with pytest.raises(instron.Unreadable, match=r"no exports .*run1\.is_tens: a Bluehill sample"):
        instron.exports(tmp_path)
