//! The module is loaded by Python and leaves Python's symbols open; macOS wants to be told.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
