"""Reads the tables of `drape export` with pandas, polars and DuckDB and compares every entry.

read_tables.py CSV PARQUET: two folders with the same tables. What counts is what Python's own module
`csv` reads from the first folder.
"""

import csv
import math
import pathlib
import sys

import duckdb
import pandas
import polars

TYPES = {"particles": int, "stiffness_over_mass": float, "step_s": float, "value": float,
         "quick": lambda text: text == "true"}


def expected(file):
    """The columns of a table; None for an empty entry."""
    with open(file, newline="", encoding="utf-8") as text:
        header, *rows = csv.reader(text)
    column = lambda k, of: [of(row[k]) if row[k] else None for row in rows]
    return {name: column(k, TYPES.get(name, str)) for k, name in enumerate(header)}


def by_pandas(file):
    if file.suffix == ".csv":
        words = {"cell": str, "scene": str, "method": str, "settings": str, "verdict": str,
                 "metric": str, "unit": str, "commit": str, "study": str, "name": str,
                 "kind": str, "meaning": str}
        frame = pandas.read_csv(file, dtype=words,
                                keep_default_na=False,
                                na_values={name: [""] for name in [*TYPES, *words]})
    else:
        frame = pandas.read_parquet(file)
    lists = {name: frame[name].tolist() for name in frame.columns}
    missing = lambda x: x is None or x is pandas.NA or (isinstance(x, float) and math.isnan(x))
    return {name: [None if missing(x) else x for x in column] for name, column in lists.items()}


def by_polars(file):
    read = polars.read_parquet
    if file.suffix == ".csv":
        typed = {"cell": polars.String, "scene": polars.String, "settings": polars.String,
                 "value": polars.Float64, "step_s": polars.Float64, "unit": polars.String,
                 "stiffness_over_mass": polars.Float64}
        return polars.read_csv(file, schema_overrides=typed, infer_schema_length=None).to_dict(
            as_series=False)
    return read(file).to_dict(as_series=False)


def by_duckdb(file):
    source = f"'{file}'"
    if file.suffix == ".csv":
        source = f"read_csv('{file}', header=true, sample_size=-1)"
    table = duckdb.sql(f"select * from {source}")
    rows = table.fetchall()
    return {name: [row[k] for row in rows] for k, name in enumerate(table.columns)}


def same(a, b):
    if a is None or b is None:
        return a is b
    if isinstance(a, float) or isinstance(b, float):
        return float(a) == float(b)
    return a == b or str(a) == str(b)


def main():
    folders = [pathlib.Path(folder) for folder in sys.argv[1:3]]
    entries = 0
    for file in sorted(folders[0].glob("*.csv")):
        wanted = expected(file)
        for folder in folders:
            read = folder / (file.stem + ("." + folder.name))
            for reader in by_pandas, by_polars, by_duckdb:
                found = reader(read)
                assert list(found) == list(wanted), (read, reader.__name__, list(found))
                for name, column in wanted.items():
                    assert len(found[name]) == len(column), (read, reader.__name__, name)
                    for row, (a, b) in enumerate(zip(column, found[name])):
                        if not same(a, b):
                            sys.exit(f"{read} by {reader.__name__}: row {row}, {name}: "
                                     f"{b!r} in place of {a!r}")
                    entries += len(column)
    print(entries)


main()
