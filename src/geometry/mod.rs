//! Shapes in double precision: the primitive, clouds and meshes. Depends on
//! nothing else of this crate.

pub mod cloud;
pub mod kernel;
pub mod mesh;
pub mod neighbors;
pub mod superquadric;
pub mod tessellate;

pub use cloud::{NO_SAMPLE, SampleCloud};
pub use mesh::TriMesh;
pub use superquadric::Superquadric;
