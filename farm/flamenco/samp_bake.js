// SPDX-License-Identifier: GPL-3.0-or-later
//
// Job type of Flamenco: bakes the takes of a jobs file in chunks of lines, then merges their reports.
// docs/farm.md says where it goes and what the settings mean.

const JOB_TYPE = {
    label: "SAMP Bake",
    description: "Bake characters that walk, sit and lie on furniture, from a jobs file of SAMP for Blender",
    settings: [
        { key: "jobs_file", type: "string", subtype: "file_path", required: true, visible: "submission",
          description: "Jobs file, a JSON object a line. Relative names in it begin in its folder" },
        { key: "lines", type: "int32", required: true, default: 1, propargs: { min: 1 }, visible: "submission",
          eval: "sum(1 for line in open(abspath(settings.jobs_file), 'rb'))",
          evalInfo: { showLinkButton: true, description: "Count the lines of the jobs file" },
          description: "Number of lines of the jobs file" },
        { key: "chunk_size", type: "int32", default: 25, propargs: { min: 1 }, visible: "submission",
          description: "Lines for each task. Blender and the networks are loaded once for each task" },
        { key: "output_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Folder for the reports, and for the takes (npz) of lines that do not say where theirs go" },
        { key: "on_failure", type: "string", default: "report", choices: ["report", "fail"], visible: "submission",
          description: "What a line does that cannot be baked: it is listed in the report, or also fails its task" },
        { key: "bake_script", type: "string", required: true, default: "{samp_bake}", visible: "submission",
          description: "The file bake.py of SAMP for Blender on the workers, or a variable of the manager" },

        // Set by Flamenco's add-on to the submitted file; lines without a scene are for it.
        { key: "blendfile", type: "string", required: false, visible: "web",
          description: "Scene of the lines that name none" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const bakeTasks = authorBakeTasks(settings);
    const mergeTask = authorMergeTask(settings);
    for (const task of bakeTasks) {
        job.addTask(task);
        mergeTask.addDependency(task);
    }
    job.addTask(mergeTask);
}

// Return a task for each chunk of lines.
function authorBakeTasks(settings) {
    const size = settings.chunk_size || 25;
    if (size < 1 || settings.lines < 1) {
        throw `Chunk size ${size} and ${settings.lines} lines cannot be used; both are at least 1`;
    }
    let scene = [];
    if (settings.blendfile) {
        scene = ["--scene", settings.blendfile];
    }
    const tasks = [];
    for (let first = 1; first <= settings.lines; first += size) {
        const lines = `${first}-${Math.min(first + size - 1, settings.lines)}`;
        const task = author.Task(`bake-${lines}`, "blender");
        task.addCommand(bakeCommand(settings, [
            "--relative-to", settings.jobs_file,
            "--lines", lines,
            "--npz", path.join(settings.output_folder, "npz"),
            "--report", path.join(settings.output_folder, "parts", `${lines}.json`),
        ].concat(scene)));
        tasks.push(task);
    }
    return tasks;
}

function authorMergeTask(settings) {
    const task = author.Task("merge", "blender");
    task.addCommand(bakeCommand(settings, [
        "--merge", path.join(settings.output_folder, "parts"),
        "--report", path.join(settings.output_folder, "report.json"),
        "--page", path.join(settings.output_folder, "index.html"),
        "--table", path.join(settings.output_folder, "takes.csv"),
    ]));
    return task;
}

// Return the command that runs bake.py over the jobs file. Not "blender-render": that needs a .blend.
function bakeCommand(settings, options) {
    return author.Command("exec", {
        exe: "{blender}",
        args: [
            "--background", "--python-exit-code", "1", "--python", settings.bake_script, "--",
            "--jobs", settings.jobs_file,
            "--on-failure", settings.on_failure || "report",
        ].concat(options),
    });
}
