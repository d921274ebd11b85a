//! Tables of text as Apache Parquet, with the types that their columns have.

use drape_harness::export::{Kind, kind};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::sync::Arc;

/// A table as the bytes of a file: one row group, compressed by Snappy. Each column may lack
/// entries: an empty text is a missing one.
///
/// # Errors
/// The entry that is none of its column's kind.
pub(crate) fn table(header: &[&str], rows: &[&[String]]) -> Result<Vec<u8>> {
    let fields = header.iter().map(|name| field(name)).collect::<Result<Vec<_>>>()?;
    let schema = Type::group_type_builder("drape").with_fields(fields).build()?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (place, name) in header.iter().enumerate() {
        let entries: Vec<&str> = rows.iter().map(|row| row[place].as_str()).collect();
        let Some(column) = group.next_column()? else { break };
        write(column, name, &entries)?;
    }
    group.close()?;
    writer.into_inner()
}

/// The type of a column.
fn field(name: &str) -> Result<Arc<Type>> {
    let (physical, logical) = match kind(name) {
        Kind::Word => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Count => (Physical::INT64, None),
        Kind::Number => (Physical::DOUBLE, None),
        Kind::Truth => (Physical::BOOLEAN, None),
    };
    let builder = Type::primitive_type_builder(name, physical);
    let builder = builder.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
    Ok(Arc::new(builder.build()?))
}

fn write(mut column: SerializedColumnWriter<'_>, name: &str, entries: &[&str]) -> Result<()> {
    // 1 where there is an entry, 0 where it is missing.
    let levels: Vec<i16> = entries.iter().map(|entry| i16::from(!entry.is_empty())).collect();
    let levels = Some(&levels[..]);
    match kind(name) {
        Kind::Word => {
            let present = entries.iter().filter(|entry| !entry.is_empty());
            let words: Vec<ByteArray> = present.map(|entry| ByteArray::from(*entry)).collect();
            column.typed::<ByteArrayType>().write_batch(&words, levels, None)?
        }
        Kind::Count => {
            column.typed::<Int64Type>().write_batch(&read(name, entries)?, levels, None)?
        }
        Kind::Number => {
            column.typed::<DoubleType>().write_batch(&read(name, entries)?, levels, None)?
        }
        Kind::Truth => {
            column.typed::<BoolType>().write_batch(&read(name, entries)?, levels, None)?
        }
    };
    column.close()
}

/// The entries of a column that are not missing.
fn read<T: std::str::FromStr>(name: &str, entries: &[&str]) -> Result<Vec<T>> {
    let one = |entry: &&str| {
        let refused = || ParquetError::General(format!("column `{name}` cannot hold `{entry}`"));
        entry.parse().map_err(|_| refused())
    };
    entries.iter().filter(|entry| !entry.is_empty()).map(one).collect()
}
