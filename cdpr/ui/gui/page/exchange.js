// Import and export of other programs' files: dialogs that stay open until the server answers, and show errors.

const MEBI = 2 ** 20;
const WAITING = { import: "Reading …", take: "Writing …", export: "Exporting …" };

class Exchange {
  constructor(home, files, live) {
    Object.assign(this, { files, live, dialogs: {}, exports: [] });
    this.importing();
    this.taking();
    this.exporting();
    home.append(
      button("Import…", () => this.files.leaving(() => this.dialogs.import.show()), { title: "A robot of another program" }),
      button("Export…", () => this.dialogs.export.show(), { title: "The robot for another program" }),
    );
  }

  // Dialog that sends the result of `request` and waits: an answer closes it, an error is shown without losing input.
  addDialog(about, title, act, request, ...parts) {
    const problem = make("p", { className: "problem", role: "alert" });
    const send = () => {
      setText(problem, "");
      this.send(about, request).catch((error) => this.receive({ about, level: "error", text: error.message }));
      return STAYS;
    };
    const { live } = this;
    const dialog = this.files.dialog(title, act, send, ...parts, problem), submit = dialog.querySelector("[type=submit]");
    const wait = (on) => { submit.disabled = on; submit.textContent = on ? WAITING[about] : act; };
    dialog.addEventListener("close", () => { if (submit.disabled) live.send({ do: "give_up" }); });
    const show = () => { setText(problem, ""); dialog.showModal(); };
    this.dialogs[about] = { dialog, submit, problem, wait, show };
    return dialog;
  }

  async send(about, request) {
    const { files, ...given } = request();
    const options = Object.fromEntries(Object.entries(given).filter(([, value]) => value !== ""));
    this.dialogs[about].wait(true);
    const gone = ({ name }) => { throw new Error(`${name}: cannot be read any more: choose it again`); };
    const read = (file) => file.arrayBuffer().catch(() => gone(file));
    const contents = files && await Promise.all(files.map(read));
    const sizes = files && { files: files.map(({ name }, i) => ({ name, size: contents[i].byteLength })) };
    if (!this.live.send({ do: about, ...options, ...sizes }, contents)) throw new Error(UNSENT);
  }

  receive(message) {
    const { dialog, problem, wait } = this.dialogs[message.about];
    wait(false);
    if (!dialog.open) return; // cancelled meanwhile
    if (message.level === "error") { setText(problem, message.text); return; }
    dialog.close();
    if (message.about === "take") this.live.form.arrive(); // not to the button that opened the dialog
    if (message.kind === "imported") this.taken(message);
    else if (message.kind === "file") this.download(message);
  }

  // Upload from the browser's machine, or a file on the server's machine.
  importing() {
    const { files } = this, chosen = make("input", { type: "file", multiple: true });
    const path = files.text({ placeholder: "file or folder, from where cdpr gui was started" });
    const set = files.text({ placeholder: "its default" }), listed = make("datalist", { id: fresh("chosen") });
    const trajectory = files.text({ placeholder: "none", list: listed.id });
    const tension = ["min", "max"].map((end) => numberBox(`Tension limits, ${end}, N`, { placeholder: end }));
    const limits = make("p", { className: "row", role: "group", "aria-label": "Tension limits (N)" },
      span("", "Tension limits (N)"), make("span", { className: "vector of2" }, ...tension));
    const seconds = numberBox(null, { placeholder: "10" });
    this.formats = make("p", { className: "none" });
    // The last input counts.
    const list = () => listed.replaceChildren(...[...chosen.files].map(({ name }) => option(name)));
    chosen.addEventListener("change", () => { path.value = ""; list(); });
    path.addEventListener("input", () => { chosen.value = ""; list(); });
    const request = () => {
      const all = [...chosen.files], size = all.reduce((sum, file) => sum + file.size, 0), { most } = this;
      const text = `at most ${most / MEBI} MiB, got ${(size / MEBI).toFixed(1)} MiB in total`;
      if (size > most) throw new Error(`Files: expected ${text}: enter their path instead.`);
      const source = all.length ? { files: all } : { path: path.value.trim() };
      const ends = tension.map((input) => reading(input.value)), given = ends.some((end) => end !== "");
      return { ...source, cable_set: set.value.trim(), trajectory: trajectory.value.trim(), tension: given ? ends : "",
        seconds: reading(seconds.value) };
    };
    this.addDialog("import", "Import from another program", "Read", request, this.formats, files.row("Choose files", chosen),
      files.row("Or enter a path", path), files.row("Cable set (CASPR)", set), files.row("Trajectory (Gazebo)", trajectory),
      limits, files.row("CPU time (s)", seconds), listed);
  }

  // Preview before anything is written.
  taking() {
    const { files } = this, folder = files.text({ placeholder: "where cdpr gui was started" });
    this.opens = make("select");
    const region = { role: "region", tabindex: 0, "aria-label": "Robots and omitted content" };
    this.brought = make("div", { className: "brought", ...region });
    const request = () => ({ out: folder.value.trim(), open: this.opens.value });
    this.addDialog("take", "Result", "Write and open", request, this.brought, files.row("Folder", folder),
      files.row("File to open", this.opens));
  }

  taken({ sources }) {
    const yaml = ({ files }) => files.map(({ name }) => name).filter((name) => name.endsWith(".yaml"));
    const names = sources.flatMap(yaml), [robot, motion] = sources.map(yaml).find((found) => found.length) || [];
    this.opens.replaceChildren(...names.map((name) => option(name, name)));
    this.opens.value = motion || robot || "";
    const read = sources.filter(({ error }) => !error).length, summary = `${read} of ${sources.length} could be read.`;
    const count = sources.length > 1 ? [make("p", { text: summary })] : [];
    this.brought.replaceChildren(...count, ...sources.flatMap((each) => this.source(each)));
    this.dialogs.take.submit.hidden = !names.length;
    this.dialogs.take.show();
  }

  source({ source, error, warnings, left_out: out, files }) {
    const items = (texts) => make("ul", {}, ...texts.map((text) => make("li", { text })));
    const list = (title, texts) => (texts.length ? [make("h4", { text: title }), items(texts)] : []);
    const text = (file) => make("pre", { tabindex: 0, text: file.text ?? "Too long to be shown here." });
    const shown = (file) => make("details", {}, make("summary", { text: `${file.name}, ${file.size} characters` }), text(file));
    return [make("h3", { text: source }), ...(error ? [make("p", { className: "problem", text: error })] : []),
      ...list("Assumed values and warnings", warnings), ...list("Omitted", out), ...files.map(shown)];
  }

  // Export of the form in a format with its options.
  exporting() {
    const { files } = this, to = make("select");
    const choices = { style: make("select"), version: make("select"), pulleys: make("select") };
    this.exported = { to, choices, fit: () => {
      const { options = {} } = this.exports.find((each) => each.to === to.value) || {};
      for (const [key, select] of Object.entries(choices)) {
        select.disabled = !options[key];
        select.replaceChildren(...Object.entries(options[key] || {}).map(([value, text]) => option(value, `${value}: ${text}`)));
      }
    } };
    to.addEventListener("change", this.exported.fit);
    const request = () => ({ to: to.value, ...Object.fromEntries(Object.entries(choices).map(([key, { value }]) => [key, value])) });
    const what = make("p", { className: "none", text: "The robot of the form, saved or not, at the start of its run." });
    this.addDialog("export", "Export for another program", "Download", request, what, files.row("Format", to),
      files.row("Style (SDF)", choices.style), files.row("Version (SDF)", choices.version),
      files.row("Pulleys (MJCF, SDF)", choices.pulleys));
  }

  download({ name, type, content }) {
    const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0));
    const address = URL.createObjectURL(new Blob([bytes], { type }));
    make("a", { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10000); // ms: a browser may first ask for a folder
  }

  list({ imports, exports, upload }) {
    Object.assign(this, { exports, most: upload });
    const known = imports.join(", ");
    setText(this.formats, `A robot of ${known}, detected by its content; choose all files of a CASPR model. Nothing is written yet.`);
    const { to, fit } = this.exported;
    if (!to.options.length) { // sent again after a lost connection: keep the selection
      to.replaceChildren(...exports.map((each) => option(each.to, each.name)));
      fit();
    }
    for (const { wait } of Object.values(this.dialogs)) wait(false); // pending requests are lost
  }
}
