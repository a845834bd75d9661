//! Where the packages of `package://name/…` are on this machine, and which file a URDF's mesh means. Nothing
//! is opened here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use perirobot_march::error::{Argument, Issue, Words};

/// Folders of packages by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packages(BTreeMap<String, PathBuf>);

impl Packages {
    /// Says where a package is; a later word overrides an earlier one.
    pub fn insert(&mut self, name: impl Into<String>, folder: impl Into<PathBuf>) {
        self.0.insert(name.into(), folder.into());
    }

    /// The names and folders.
    pub(super) fn folders(&self) -> impl Iterator<Item = (String, PathBuf)> {
        self.0.iter().map(|(name, folder)| (name.clone(), folder.clone()))
    }

    /// The file that a mesh in a URDF means: `package://` by its name here, everything else from the URDF's
    /// folder.
    pub(super) fn resolve(&self, filename: &str, urdf: &Path) -> Result<PathBuf, Issue> {
        let folder = urdf.parent().unwrap_or(Path::new(""));
        if let Some(rest) = filename.strip_prefix("package://") {
            let (name, rest) = rest.split_once(['/', '\\']).unwrap_or((rest, ""));
            let package = self.0.get(name).ok_or_else(|| self.unknown(name))?;
            return Ok(package.join(rest.trim_start_matches(['/', '\\'])));
        }
        match filename.split_once("://") {
            Some(("file", rest)) => Ok(folder.join(rest)),
            Some((scheme, _)) => Err(Issue::unsupported(format!("{scheme:.20}:// is not supported"))
                .with_advice("write package://name/… or a path from the URDF's folder")),
            None => Ok(folder.join(filename)),
        }
    }

    fn unknown(&self, name: &str) -> Issue {
        let known: Vec<&str> = self.0.keys().map(String::as_str).collect();
        let known =
            if known.is_empty() { String::new() } else { format!(" (known are {})", known.join(", ")) };
        Issue::says(format!("package {name:?} is not known{known}")).with_advice(
            Words::from("say where it is with ")
                + Argument("package").with_value(format!("{name}=DIR"))
                + format!(" or with packages = {{ {name} = \"DIR\" }} in the scene file"),
        )
    }
}

impl<N: Into<String>, F: Into<PathBuf>> FromIterator<(N, F)> for Packages {
    fn from_iter<I: IntoIterator<Item = (N, F)>>(folders: I) -> Self {
        Packages(folders.into_iter().map(|(name, folder)| (name.into(), folder.into())).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_found_by_package_or_beside_the_urdf() {
        let packages = Packages::from_iter([("ur_description", "/ros/ur")]);
        let urdf = Path::new("robots/urdf/arm.urdf");
        for (filename, expected) in [
            ("package://ur_description/meshes/base.stl", "/ros/ur/meshes/base.stl"),
            ("package://ur_description//base.stl", "/ros/ur/base.stl"),
            ("base.stl", "robots/urdf/base.stl"),
            ("../meshes/base.stl", "robots/urdf/../meshes/base.stl"),
            ("file:///ros/base.stl", "/ros/base.stl"),
            ("file://base.stl", "robots/urdf/base.stl"),
            ("/ros/base.stl", "/ros/base.stl"),
            (r"package://ur_description\meshes\base.stl", r"/ros/ur/meshes\base.stl"),
        ] {
            assert_eq!(packages.resolve(filename, urdf), Ok(PathBuf::from(expected)), "{filename}");
        }
    }

    #[test]
    fn what_cannot_be_found_says_how_to_help() {
        let mut packages = Packages::default();
        let urdf = Path::new("arm.urdf");
        let what = packages.resolve("package://ur/base.stl", urdf).unwrap_err();
        assert_eq!(
            what.to_string(),
            "package \"ur\" is not known: say where it is with package ur=DIR or with packages = { ur = \"DIR\" } \
             in the scene file"
        );
        packages.insert("other", "x");
        assert!(
            packages.resolve("package://ur", urdf).unwrap_err().to_string().contains("(known are other)")
        );
        assert!(
            packages
                .resolve("http://x/base.stl", urdf)
                .unwrap_err()
                .to_string()
                .starts_with("http:// is not")
        );
    }
}
