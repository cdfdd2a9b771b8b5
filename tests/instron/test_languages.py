"""Headers of many languages and code pages: the same columns are found in each."""

import numpy as np
import pytest

import instron

N = 30
T = np.round(np.arange(N) * 0.1, 1)
X = np.round(T * 0.5, 3)
F = np.round(1200 * np.sin(np.arange(N) / 10) - 3.25, 2)

# encoding; preamble; names of time, displacement, force and of a column to pass over
HEADERS = {
    "Polish": ("cp1250", "Właściwości próbki : Długość", "Godzina;Przemieszczenie;Obciążenie",
               "Odkształcenie 1"),
    "Polish of the load cell": ("cp1250", "Próbka", "Czas;Wydłużenie;Siła", "Naprężenie"),
    "Polish, UTF-8": ("utf-8", "Próbka", "Czas;Droga;Siła", "Odkształcenie"),
    "German": ("cp1252", "Allgemein : Prüfer", "Zeit;Traversenweg;Last", "Dehnung 1"),
    "German, Universal": ("cp1252", "Prüfer", "Zeit;Verschiebung;Kraft", "Zugspannung"),
    "German, length": ("cp1252", "Prüfer", "Prüfzeit;Längenänderung;Prüfkraft", "Spannung"),
    "German of DOS": ("cp850", "Prüfer", "Prüfzeit;Längenänderung;Prüfkraft", "Spannung"),
    "French of a Mac": ("mac_roman", "Opérateur", "Temps;Déplacement;Force", "Contrainte"),
    "French, UTF-16 without mark": ("utf-16-be", "Essai", "Temps;Déplacement;Force", "Contrainte"),
    "French": ("cp1252", "Opérateur", "Temps;Extension;Charge", "Déformation en traction"),
    "French, Universal": ("cp1252", "Opérateur", "Temps;Déplacement;Force", "Contrainte"),
    "French, crosshead": ("utf-8", "Éprouvette", "temps;traverse;force", "Contrainte"),
    "Spanish": ("cp1252", "Máximo Carga : TiempoalMáximo Carga", "Tiempo;Extensión;Carga",
                "Deformación por tracción"),
    "Spanish, Universal": ("utf-8", "Probeta", "tiempo;desplazamiento;carga", "Esfuerzo"),
    "Portuguese": ("cp1252", "Número", "Tempo;Extensão;Carga", "Tensão"),
    "Italian": ("cp1252", "Velocità", "Tempo;Spostamento;Carico", "Sforzo"),
    "Dutch": ("cp1252", "Proefstuk", "Tijd;Verplaatsing;Kracht", "Rek"),
    "Swedish": ("cp1252", "Provstav", "Tid;Förlängning;Last", "Spänning"),
    "Czech": ("cp1250", "Vzorek č. 1", "Čas;Prodloužení;Zatížení", "Napětí"),
    "Hungarian": ("cp1250", "Próbatest", "Idő;Elmozdulás;Terhelés", "Feszültség"),
    "Turkish": ("cp1254", "Numune", "Zaman;Uzama;Yük", "Gerilme"),
    "Russian": ("cp1251", "Образец", "Время;Перемещение;Нагрузка", "Напряжение"),
    "Ukrainian": ("utf-8", "Зразок", "Час;Переміщення;Зусилля", "Напруження"),
    "Greek": ("utf-8", "Δοκίμιο", "Χρόνος;Μετατόπιση;Δύναμη", "Τάση"),
    "Romanian": ("utf-8", "Epruvetă", "Timp;Deplasare;Forță", "Efort"),
    "Croatian": ("utf-8", "Uzorak", "Vrijeme;Pomak;Sila", "Naprezanje"),
    "Chinese": ("gb18030", "试样", "时间;位移;载荷", "压缩应变 (位移)"),
    "Chinese, tension": ("gbk", "试样", "时间;拉伸位移;力", "拉伸应力"),
    "Chinese, traditional": ("big5", "試片", "時間;位移;荷重", "應力"),
    "Japanese": ("shift_jis", "試験片", "時間;伸び;荷重", "応力"),
    "Japanese, UTF-16": ("utf-16", "試験片", "時間;ストローク;試験力", "ひずみ"),
    "Korean": ("cp949", "시편", "시간;변위;하중", "응력"),
    "Korean beside English": ("cp949", "1 _ 1", "Time;스트로크;Force", "Height"),
    "Japanese beside English": ("shift_jis", "1 _ 1", "Time;ストローク;Force", "Height"),
    "Chinese beside English": ("gbk", "1 _ 1", "Time;位移;Force", "Height"),
    "Chinese, traditional, beside English": ("big5", "1 _ 1", "Time;位移;Force", "Height"),
}  # fmt: skip


def export(header, units):
    encoding, preamble, names, other = header
    rows = "".join(f"{t};{x};{f};{f / 9:.3f}\r\n" for t, x, f in zip(T, X, F, strict=True))
    head = f"{preamble};1,5;mm\r\n\r\n{names};{other}\r\n" + (f"{units};MPa\r\n" if units else "")
    return (head + rows.replace(".", ",")).encode(encoding)


@pytest.mark.parametrize("language", HEADERS)
def test_every_language_is_read_exactly(language, tmp_path):
    path = tmp_path / "export.csv"
    path.write_bytes(export(HEADERS[language], "(s);(mm);(kN)"))
    (log,) = instron.read(path)
    assert log.attrs["warnings"] == []
    assert [c["name"] for c in log.attrs["columns"].values()] == HEADERS[language][2].split(";")
    np.testing.assert_allclose(log["time"], T, rtol=1e-12)
    np.testing.assert_allclose(log["displacement"], X * 1e-3, rtol=1e-12)
    np.testing.assert_allclose(log["force"], F * 1e3, rtol=1e-12)


SYMBOLS = ["t [s];s [mm];F [N]", "t (s);x (mm);F (N)", "Zeit [s];dL [mm];F [N]"]


@pytest.mark.parametrize("header", SYMBOLS)
def test_symbols_count_where_their_unit_agrees(header, tmp_path):
    path = tmp_path / "export.csv"
    path.write_text(header + "\n0,5;1,25;10,4\n1,0;2,5;11,75\n")
    log = instron.read(path)[0]
    assert log["force"].tolist() == [10.4, 11.75]
    np.testing.assert_allclose(log["displacement"], [1.25e-3, 2.5e-3])
    path.write_text("t;s;F\n0,5;1,25;10,4\n1,0;2,5;11,75\n")
    with pytest.raises(instron.Unreadable, match="no header"):
        instron.read(path)
