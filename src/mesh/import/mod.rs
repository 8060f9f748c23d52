pub fn read(_: &std::path::Path, _: f64) -> crate::Result<(super::Mesh, Vec<String>)> {
    unreachable!()
}
