pub fn check(_: &mut super::Mesh, _: &str) -> crate::Result<Vec<String>> {
    Ok(vec![])
}
