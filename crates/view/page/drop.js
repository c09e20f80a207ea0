// Files dropped on the page: uploaded, then opened.

const SCENES = ["glb", "gltf", "obj", "ply", "pbrt", "xml"];
const ENVIRONMENTS = ["hdr", "exr"];
const extension = (path) => path.split(".").pop().toLowerCase();

export function watchDrops(link, notice) {
  const body = document.body;
  const open = async (files) => {
    try {
      await upload(link, files, notice);
    } catch (error) {
      notice(String(error.message ?? error));
    }
  };
  let depth = 0;
  body.addEventListener("dragenter", () => { depth += 1; body.classList.add("dropping"); });
  body.addEventListener("dragleave", () => { if (--depth <= 0) { depth = 0; body.classList.remove("dropping"); } });
  body.addEventListener("dragover", (event) => event.preventDefault());
  body.addEventListener("drop", async (event) => {
    event.preventDefault();
    depth = 0;
    body.classList.remove("dropping");
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    const plain = [...event.dataTransfer.files].map((file) => ({ path: file.name, file }));
    await open(entries.length ? (await Promise.all(entries.map((entry) => walk(entry, "")))).flat() : plain);
  });
  for (const id of ["file", "folder"]) {
    document.getElementById(id).addEventListener("change", async (event) => {
      await open([...event.target.files].map((file) => ({ path: file.webkitRelativePath || file.name, file })));
      event.target.value = "";
    });
  }
}

/** All files below an entry, with their paths. */
async function walk(entry, folder) {
  const path = folder + entry.name;
  if (entry.isFile) {
    return [{ path, file: await new Promise((done, failed) => entry.file(done, failed)) }];
  }
  const reader = entry.createReader();
  const files = [];
  for (;;) {
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return files;
    for (const one of some) files.push(...(await walk(one, `${path}/`)));
  }
}

async function upload(link, files, notice) {
  const seen = files.filter(({ path }) => !path.split("/").some((name) => name.startsWith(".")));
  const first = (kinds) => seen.filter(({ path }) => kinds.includes(extension(path)))
    .sort((a, b) => a.path.split("/").length - b.path.split("/").length)[0];
  const main = first(SCENES) ?? first(ENVIRONMENTS);
  if (!main) throw new Error("Nothing in there is a scene (.glb, .gltf, .obj, .ply, .pbrt, .xml) or an environment (.hdr, .exr).");
  const batch = Date.now();
  for (const [i, { path, file }] of seen.entries()) {
    notice(`uploading ${i + 1} of ${seen.length}: ${path}`);
    await link.upload(batch, path, file);
  }
  link.send({ type: "open", batch, path: main.path });
}
