//! Writes the seeds of the fuzz targets into `fuzz/seeds`: small files that load.

use std::{fs, io::Cursor, path::Path};

use image::{DynamicImage, ImageFormat, RgbaImage};

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds");
    let write = |target: &str, name: &str, bytes: &[u8]| {
        let folder = root.join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), bytes)
    };
    let pixels =
        RgbaImage::from_fn(5, 3, |x, y| image::Rgba([x as u8 * 50, y as u8 * 90, 128, 255 - x as u8]));
    let pixels = DynamicImage::from(pixels);
    for (target, name, format) in [
        ("image", "a.png", ImageFormat::Png),
        ("image", "a.jpg", ImageFormat::Jpeg),
        ("image", "a.webp", ImageFormat::WebP),
        ("image", "a.bmp", ImageFormat::Bmp),
        ("hdr", "a.hdr", ImageFormat::Hdr),
        ("exr", "a.exr", ImageFormat::OpenExr),
    ] {
        write(target, name, &encoded(&pixels, format))?;
    }
    let level = [10, 20, 30, 40];
    // A frame of one segment of 4 bytes, in a single raw block.
    let zstd = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 4, 4 << 3 | 1, 0, 0], &level[..]].concat();
    write("ktx", "plain.ktx2", &ktx(0, &level))?;
    write("ktx", "zstd.ktx2", &ktx(2, &zstd))?;
    write("ply", "ascii.ply", PLY.as_bytes())?;
    write("ply", "binary.ply", &binary_ply())?;
    write("obj", "all.obj", OBJ.as_bytes())?;
    write("gltf", "all.gltf", GLTF.as_bytes())?;
    write("glb", "triangle.glb", &glb())?;
    write("meshopt", "indices", &[2, 0, 4, 3, 0, 0xd1, 0, 4, 4, 0, 0, 0, 0])?;
    write("mitsuba", "all.xml", include_bytes!("seeds/all.xml"))?;
    write("pbrt", "v4.pbrt", include_bytes!("seeds/v4.pbrt"))?;
    write("pbrt", "v3.pbrt", include_bytes!("seeds/v3.pbrt"))?;
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
    for entry in fs::read_dir(scenes.join("mitsuba"))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.extension().is_some_and(|e| e == "xml") {
            write("mitsuba", &name, &fs::read(&path)?)?;
        }
    }
    let meshes = fs::read(scenes.join("mitsuba/meshes.serialized"))?;
    for index in 0..2u8 {
        write("serialized", &index.to_string(), &[&[index], &meshes[..]].concat())?;
    }
    write("pbrt", "box.pbrt", &fs::read(scenes.join("same/box.pbrt"))?)
}

/// A KTX2 file of two texels of two bytes, stored by a supercompression scheme.
fn ktx(scheme: u32, stored: &[u8]) -> Vec<u8> {
    let (header, length) = (104, stored.len() as u32);
    let [vk_format, type_size, width, height, faces, levels] = [16, 1, 2, 1, 1, 1];
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let words = [vk_format, type_size, width, height, 0, 0, faces, levels, scheme];
    let index = [0; 8];
    let level = [header, 0, length, 0, 4, 0];
    bytes.extend(words.into_iter().chain(index).chain(level).flat_map(u32::to_le_bytes));
    bytes.extend(stored);
    bytes
}

fn encoded(pixels: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let written = match format {
        ImageFormat::Jpeg => pixels.to_rgb8().write_to(&mut bytes, format),
        ImageFormat::Hdr => pixels.to_rgb32f().write_to(&mut bytes, format),
        ImageFormat::OpenExr => pixels.to_rgba32f().write_to(&mut bytes, format),
        _ => pixels.write_to(&mut bytes, format),
    };
    written.expect("the format holds such pixels");
    bytes.into_inner()
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n\
    0 0 0 0 0 1 0 0 255 0 0\n1 0 0 0 0 1 1 0 0 255 0\n1 1 0 0 0 1 1 1 0 0 255\n0 1 0 0 0 1 0 1 9 9 9\n4 0 1 2 3\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes =
        b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
            .to_vec();
    bytes.extend([0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_be_bytes()));
    bytes.extend([4i32, 0, 1, 2, -1].iter().flat_map(|x| x.to_be_bytes()));
    bytes
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
    vn 0 0 1\no a\ns 1\nusemtl a\nf 1/1/1 2/2/1 3/3/1\nusemtl b\ns off\nf -4 -3 -2 -1\nl 1 2\n\0\
    newmtl a\nKd 0.5 0.4 0.3\nKs 0.1\nNs 50\nillum 2\nKe 1 2 3\nd 0.5\nmap_Kd -s 2 2 -o 0.5 0 -clamp on m.mtl\n\
    norm -bm 0.5 n.png\nnewmtl b\nPr 0.2\nPm 1\nPs 0.1\nPc 0.3\nPcr 0.1\naniso 0.2\nNi 1.4\nTf 1 1 1\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":5,"spot":{"outerConeAngle":0.5}}]}},
"nodes":[{"mesh":0,"scale":[1,2,3],"weights":[0.5],"extensions":{"KHR_lights_punctual":{"light":0},
"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}},{"camera":0,"rotation":[0,0,0,1],"children":[2]},{}],
"cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":2,"znear":1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0,"TEXCOORD_0":1,"COLOR_0":0},"indices":2,"material":0,
"mode":5,"targets":[{"POSITION":0}]}]}],
"materials":[{"alphaMode":"MASK","doubleSided":true,"emissiveFactor":[1,1,1],"normalTexture":{"index":0,"scale":2},
"pbrMetallicRoughness":{"metallicFactor":0.5,"baseColorTexture":{"index":0,"texCoord":1,"extensions":
{"KHR_texture_transform":{"rotation":1,"scale":[2,2]}}}},"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":1},
"KHR_materials_sheen":{"sheenColorFactor":[1,1,1]},"KHR_materials_transmission":{"transmissionFactor":1},
"KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":1,"attenuationColor":[0.5,0.5,0.5]},
"KHR_materials_anisotropy":{"anisotropyStrength":1},"KHR_materials_specular":{"specularFactor":0.5}}}],
"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071,"magFilter":9728}],
"images":[{"uri":"data:image/bmp;base64,Qk0="}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,
"indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":0}}},
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":42,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}]}"#;

fn glb() -> Vec<u8> {
    let mut text = br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"buffers":[{"byteLength":36}],
"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]}"#
        .to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let binary: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((text.len() as u32 + binary.len() as u32 + 28).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
