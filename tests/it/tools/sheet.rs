//! Tests of contact sheets: `render --sheet` with many files.

use image::RgbImage;

use crate::common::{Workspace, repository};

/// Writes four maps of different formats, two damaged files and a photograph.
fn write_files(here: &Workspace) {
    for (name, file) in [
        ("files/b.ptm", "lrgb/first-lrgb.ptm"),
        (
            "files/a/Ä long name that has to be shortened 001.PTM",
            "rgb/first-rgb.ptm",
        ),
        ("files/c.ptm", "lum/first-lum.ptm"),
        ("files/d.ptm", "lrgb/half-payload-lrgb.ptm"),
        ("files/photo.jpg", "MANIFEST.yaml"),
    ] {
        let bytes = std::fs::read(repository(&format!("corpus/{file}"))).expect("a file");
        here.write(name, bytes);
    }
    here.write("files/e.ptm", "PTM_1.1\n");
}

fn image(here: &Workspace, name: &str) -> RgbImage {
    let image = image::load_from_memory(&here.read(name)).expect("an image");
    image.into_rgb8()
}

#[test]
fn folder_becomes_numbered_sheets() {
    let here = Workspace::new();
    write_files(&here);
    let text = here.succeeds("render files --sheet 2 --cell 60 -o sheet.png");
    assert!(
        text.contains("sheet-1.png: 4 files") && text.contains("sheet-2.png: 1 file\n"),
        "{text}"
    );
    assert!(text.contains("2 of 5 files have no thumbnail"), "{text}");
    assert!(!here.path("sheet.png").exists());
    let [first, second] = ["sheet-1.png", "sheet-2.png"].map(|name| image(&here, name));
    // Cells of 60 x 77 pixels, 12 apart.
    assert_eq!(first.dimensions(), (12 + 2 * 72, 12 + 2 * 89));
    assert_eq!(second.dimensions(), (12 + 72, 12 + 89));
    let red = |sheet: &RgbImage, x, y| {
        let [red, green, _] = sheet.get_pixel(x, y).0;
        red > green + 40
    };
    // In the order of the paths, files/d.ptm is the fourth and files/e.ptm the fifth.
    // The fifth has another version, which is no damage.
    assert!(red(&first, 84, 101) && !red(&second, 12, 12));
    assert!(!red(&first, 84, 12));

    let text = here.succeeds("render files/c.ptm files/b.ptm --sheet -o two.png");
    assert!(text.contains("two.png: 2 files"), "{text}");
    here.succeeds("render files/b.ptm files/c.ptm --sheet -o two-sorted.png");
    assert_eq!(here.read("two.png"), here.read("two-sorted.png"));
}

#[test]
fn contact_sheets_explain_what_they_need() {
    let here = Workspace::new();
    write_files(&here);
    std::fs::create_dir(here.path("empty")).expect("a folder");
    here.assert_lines(
        "
2 | render files -o x.png | need --sheet
2 | render files/b.ptm files/c.ptm -o x.png | need --sheet
2 | render files --sheet -o x.html | lint --format html
2 | render --sheet files -o x.png | write the paths before --sheet
2 | render files --sheet 26 -o x.png | a number from 1 to 25
2 | render files --sheet --cell 9000 -o x.png | too large
5 | render empty --sheet -o x.png | no file is named .ptm
2 | render files none.ptm --sheet -o x.png | none.ptm: No such file && x.png: 6 files
0 | render files/b.ptm --sheet -o x.png | 5 x 5 lights",
    );
}
