//! VTK files: read back with the reader's own eyes, and the XML around them.

use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::fs;
use tempfile::TempDir;
use thinshell::Error;
use thinshell::case::vtk::{self, Faces, Surface};
use thinshell::snapshot::{Association, Field};
use vtkio::model::{Attribute, DataSet, Piece};

const FACES: [[usize; 3]; 2] = [[0, 1, 2], [2, 1, 3]];

fn points() -> Vec<Vector3<f64>> {
    (0..4).map(|i| Vector3::new(f64::from(i % 2), f64::from(i / 2), 0.1 * f64::from(i))).collect()
}

fn field(name: &str, association: Association, components: usize, entries: usize) -> Field {
    let data = (0..components * entries).map(|i| 0.1 * i as f64 - 1e-9).collect();
    Field { name: name.into(), association, components, unit: "m".into(), data }
}

#[test]
fn surface_comes_back() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("vtk/state_000.vtp");
    let points = points();
    let point_data: Vec<_> = [1, 3, 6, 9].map(|c| field(&format!("at-{c} <&\">"), Association::Node, c, 4)).into();
    let cell_data = vec![field("moisture", Association::Face, 1, 2)];
    let surface = Surface { points: &points, faces: Faces::Linear(&FACES), point_data: point_data.clone(), cell_data: cell_data.clone() };
    surface.write(&path).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("Name=\"at-6 &lt;&amp;&quot;&gt;\""), "{text}");

    let DataSet::PolyData { mut pieces, .. } = vtkio::Vtk::import(&path).unwrap().data else { panic!("no PolyData") };
    let Some(Piece::Inline(piece)) = pieces.pop() else { panic!("no piece") };
    assert_eq!(piece.points.into_vec::<f64>().unwrap(), points.iter().flat_map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>());
    assert_eq!(piece.polys.unwrap().into_xml(), (vec![0, 1, 2, 2, 1, 3], vec![3, 6]));
    for (read, fields) in [(piece.data.point, point_data), (piece.data.cell, cell_data)] {
        assert_eq!(read.len(), fields.len());
        for (attribute, field) in read.into_iter().zip(fields) {
            let Attribute::DataArray(array) = attribute else { panic!("no array") };
            assert_eq!(array.num_comp(), field.components);
            assert_eq!(array.data.into_vec::<f64>().unwrap(), field.data);
        }
    }
}

#[test]
fn field_of_another_length_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("state.vtp");
    let points = points();
    let point_data = vec![field("velocity", Association::Node, 3, 3)];
    let refused = Surface { points: &points, faces: Faces::Linear(&FACES), point_data, cell_data: vec![] }.write(&path);
    match refused {
        Err(Error::Input { message, .. }) => assert!(message.contains("velocity") && message.contains('9'), "{message}"),
        other => panic!("{other:?}"),
    }
    assert!(!path.exists());
}

#[test]
fn series_escapes_names_and_keeps_times() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("case.pvd");
    let files = vec![(0.0, "a.vtp".to_string()), (0.1 + 0.2, "<b>&\"c\".vtp".to_string()), (1e-12, "d.vtp".into())];
    vtk::write_series(&path, &files, None).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("timestep=\"0.30000000000000004\" part=\"0\" file=\"&lt;b&gt;&amp;&quot;c&quot;.vtp\"/>"), "{text}");
    assert!(text.contains("timestep=\"1e-12\""));
    assert_eq!(text.matches("<DataSet ").count(), 3);
    vtk::write_units(&folder.path().join("units.json"), &BTreeMap::from([("velocity".into(), "m/s".into())])).unwrap();
    let units: serde_json::Value = serde_json::from_slice(&fs::read(folder.path().join("units.json")).unwrap()).unwrap();
    assert_eq!(units["velocity"], "m/s");
}
