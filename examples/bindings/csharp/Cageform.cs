// Packed figures in C# 7, for Unity and mono: open, clone, play clips, pose by pins; and wraps. This file calls the C interface of the
// shared library (include/cageform/c/cageform.h). It allocates no memory per frame and has no unsafe code.
//
// Points are 3D in float: x y z each, in arrays or at addresses. Errors of the library throw a CageformException. Arrays that are
// too short throw an ArgumentException. Several threads may use a Figure at once; only one at a time may use a
// Player or Pins.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Cageform
{
    /// An error status of the library.
    public sealed class CageformException : Exception
    {
        /// The code of the status, which never changes, and its name, such as "blob_corrupt".
        public readonly int Code;
        public readonly string Name;
        /// The invalid element: the index of a pin or handle, or the four letters of the part of a file; null if there is none.
        public readonly string Culprit;

        internal CageformException(int code, string culprit = null, string message = null)
            : base(message ?? Native.Text(Native.cageform_status_text(code)))
        {
            Code = code;
            Name = Native.Text(Native.cageform_status_name(code));
            Culprit = culprit;
        }
    }

    /// A packed figure: a file written by bind_mesh, the Python or npm package, or cageform_pack.
    public sealed class Figure : IDisposable
    {
        internal readonly Handle Handle;
        public readonly int Points, Handles, Clips, Levels;
        /// Number of handles that are vertices of the cage: the size of clips and of the input of PoseHandles.
        public readonly int Vertices;
        public readonly bool HasNormals, HasTangents;
        /// The origin x, y, z of the coordinates of points, handles and clips. Add it to clones in double precision.
        public readonly double[] Origin;

        /// Opens a packed figure. Copies the bytes.
        public Figure(byte[] bytes) : this(Open(bytes)) { }

        Figure(Handle handle)
        {
            Handle = handle;
            var info = new Native.FigureInfo { size = Native.SizeOf<Native.FigureInfo>() };
            int code = Native.cageform_figure_describe(handle, ref info);
            if (code == 0 && info.scalar != Native.Float) code = Native.ScalarDiffers;
            if (code == 0 && info.dimension != 3) code = Native.DimensionDiffers;
            if (code != 0)
            {
                handle.Dispose();
                throw new CageformException(code);
            }
            Points = checked((int)info.points);
            Handles = checked((int)info.handles);
            Vertices = checked((int)info.vertices);
            Clips = checked((int)info.clips);
            Levels = checked((int)info.levels);
            HasNormals = info.has_normals != 0;
            HasTangents = info.has_tangents != 0;
            Origin = info.origin;
        }

        static Handle Open(byte[] bytes)
        {
            var memory = new AlignedBytes(bytes);
            Handle handle;
            UIntPtr part;
            int code = Native.cageform_open(memory.Data, memory.Size, IntPtr.Zero, out handle, out part);
            if (code == 0) return handle.Keep(memory);
            memory.Free();
            ulong tag = (ulong)part;
            if (tag == 0 || tag > uint.MaxValue) throw new CageformException(code);
            string name = Encoding.ASCII.GetString(BitConverter.GetBytes((uint)tag));
            throw new CageformException(code, name, Native.Text(Native.cageform_status_text(code)) + " (part " + name + ")");
        }

        /// Opens a level of less detail, for the same poses; level 0 is the figure itself.
        public Figure Level(int level)
        {
            Handle handle;
            Native.Check(Native.cageform_open_level(Handle, Native.Index(level, "level"), IntPtr.Zero, out handle));
            return new Figure(handle.Keep(Handle));
        }

        /// Writes the handles at rest, the initial pose: 3 * Handles numbers.
        public void Rest(float[] pose)
        {
            using (var to = new Pinned(pose, 3, Handles, "pose"))
                Native.Check(Native.cageform_figure_rest(Handle, to.View));
        }

        /// Deforms the figure by a pose of all handles. Tangents, or normals and tangents, may be null. Tangents are x y z w
        /// each; w is the handedness.
        public void Clone(float[] pose, float[] points, float[] normals = null, float[] tangents = null)
        {
            using (var from = new Pinned(pose, 3, Handles, "pose"))
            using (var to = new Pinned(points, 3, Points, "points"))
            using (var turned = normals == null ? default(Pinned) : new Pinned(normals, 3, Points, "normals"))
            using (var along = tangents == null ? default(Pinned) : new Pinned(tangents, 4, Points, "tangents"))
                Clone(from.Address, to.Address, turned.Address, along.Address);
        }

        /// As above, with addresses, such as those of GetUnsafePtr of NativeArray: a pose of Handles points, and memory for
        /// Points points, normals, tangents. Tangents, or normals and tangents, may be IntPtr.Zero. A wrong address, or
        /// memory that is too short, crashes the program.
        public void Clone(IntPtr pose, IntPtr points, IntPtr normals, IntPtr tangents)
        {
            Native.Points from = Pinned.ViewOf(pose, 3, Handles), to = Pinned.ViewOf(points, 3, Points);
            Native.Points turned = Pinned.ViewOf(normals, 3, Points), along = Pinned.ViewOf(tangents, 4, Points);
            int code;
            if (normals == IntPtr.Zero && tangents == IntPtr.Zero)
                code = Native.cageform_clone(Handle, from, to, IntPtr.Zero, IntPtr.Zero, IntPtr.Zero);
            else if (tangents == IntPtr.Zero)
                code = Native.cageform_clone(Handle, from, to, ref turned, IntPtr.Zero, IntPtr.Zero);
            else
                code = Native.cageform_clone(Handle, from, to, ref turned, ref along, IntPtr.Zero);
            Native.Check(code);
        }

        /// Computes a pose of all handles from a pose of the cage's vertices. Green coordinates need it.
        public void PoseHandles(float[] vertices, float[] handles)
        {
            using (var from = new Pinned(vertices, 3, Vertices, "vertices"))
            using (var to = new Pinned(handles, 3, Handles, "handles"))
                Native.Check(Native.cageform_pose_handles(Handle, from.View, to.View));
        }

        /// Returns the label of a handle; empty if it has none.
        public string Label(int handle)
        {
            IntPtr text;
            UIntPtr length;
            Native.Check(Native.cageform_figure_label(Handle, Native.Index(handle, "handle"), out text, out length));
            var bytes = new byte[(int)length];
            if (bytes.Length > 0) Marshal.Copy(text, bytes, 0, bytes.Length);
            return Encoding.UTF8.GetString(bytes);
        }

        /// Returns the first handle with a label; -1 if there is none.
        public int FindHandle(string label)
        {
            byte[] text = Encoding.UTF8.GetBytes(label);
            UIntPtr handle;
            Native.Check(Native.cageform_figure_find_handle(Handle, text, (UIntPtr)text.Length, out handle));
            return (ulong)handle < (ulong)Handles ? (int)handle : -1;
        }

        /// Creates a player of a clip, given by name. Create one player per playing character.
        public Player Play(string name)
        {
            byte[] text = Encoding.UTF8.GetBytes(name);
            UIntPtr clip;
            Native.Check(Native.cageform_figure_find_clip(Handle, text, (UIntPtr)text.Length, out clip));
            if ((ulong)clip >= (ulong)Clips) throw new ArgumentException("the figure has no clip " + name, "name");
            Handle handle;
            Native.Check(Native.cageform_play(Handle, clip, IntPtr.Zero, out handle));
            return new Player(handle.Keep(Handle));
        }

        public void Dispose() { Handle.Dispose(); }
    }

    /// Plays a clip, the motion of a cage's vertices.
    public sealed class Player : IDisposable
    {
        readonly Handle handle;
        public readonly int Vertices;
        public readonly double Begin, End;

        internal Player(Handle handle)
        {
            this.handle = handle;
            var info = new Native.ClipInfo { size = Native.SizeOf<Native.ClipInfo>() };
            Native.Check(Native.cageform_player_describe(handle, ref info));
            Vertices = checked((int)info.vertices);
            Begin = info.begin;
            End = info.end;
        }

        /// Writes the cage's vertices at a time: 3 numbers each.
        public void Sample(double time, float[] vertices)
        {
            using (var to = new Pinned(vertices, 3, Vertices, "vertices"))
                Native.Check(Native.cageform_player_sample(handle, time, to.View));
        }

        public void Dispose() { handle.Dispose(); }
    }

    /// Moves a cage so that pinned points reach targets and its interior deforms as rigidly as possible.
    public sealed class Pins : IDisposable
    {
        readonly Handle handle;
        readonly IntPtr report;
        int pins;
        public readonly int Handles;

        /// Opens packed samples of the cage. Copies the bytes.
        ///   pinWeight   stiffness of a pin of weight 1 relative to the stretch of the figure; 0: 1e4
        ///   hard        pins are a thousand times nearer to their targets
        ///   iterations  per call of Solve; 0: 4
        public Pins(byte[] samples, double pinWeight = 0, bool hard = false, int iterations = 0)
        {
            var memory = new AlignedBytes(samples);
            Handle opened = null;
            try
            {
                Native.Check(Native.cageform_samples_open(memory.Data, memory.Size, 0, out opened));
                var info = new Native.SamplesInfo { size = Native.SizeOf<Native.SamplesInfo>() };
                Native.Check(Native.cageform_samples_describe(opened, ref info));
                if (info.scalar != Native.Float) throw new CageformException(Native.ScalarDiffers);
                if (info.dimension != 3) throw new CageformException(Native.DimensionDiffers);
                Handles = checked((int)info.handles);
                var options = new Native.PinsOptions { size = Native.SizeOf<Native.PinsOptions>(), pin_weight = pinWeight,
                                                       hard = hard ? 1 : 0, iterations = Native.Index(iterations, "iterations") };
                Native.Check(Native.cageform_pins_create(opened, ref options, out handle));
            }
            finally
            {
                if (opened != null) opened.Dispose();
                memory.Free();
            }
            var room = Native.NewReport();
            handle.Keep(room);
            report = room.Data;
        }

        /// Replaces all pins by pins at points of a figure, given by index. Weights may be null: all are 1.
        public void Set(Figure figure, int[] points, double[] weights = null)
        {
            if (weights != null && weights.Length != points.Length) throw new ArgumentException("one weight per pin is needed", "weights");
            Native.Check(Native.cageform_pins_set(handle, figure.Handle, points, (UIntPtr)points.Length, weights, report), report);
            pins = points.Length;
        }

        /// Replaces the set of fixed handles, which keep their positions in the pose.
        public void Hold(int[] handles)
        {
            Native.Check(Native.cageform_pins_hold(handle, handles, (UIntPtr)handles.Length, report), report);
        }

        /// Moves a pose of all handles towards the targets, one per pin. Call it once per frame until it returns true:
        /// the pose has settled.
        public bool Solve(float[] targets, float[] pose)
        {
            using (var from = new Pinned(targets, 3, pins, "targets"))
            using (var to = new Pinned(pose, 3, Handles, "pose"))
                Native.Check(Native.cageform_pins_solve(handle, from.View, to.View, report), report);
            return Marshal.ReadInt32(report, settled) != 0;
        }

        /// The largest distance of a pin from its target in the last frame.
        public double Miss { get { return Native.Number(report, miss); } }

        static readonly int settled = Native.OffsetOf("settled"), miss = Native.OffsetOf("miss");

        public void Dispose() { handle.Dispose(); }
    }

    /// A map of space that lays one figure, the source, on another, the target. Clothes, hair and joints of the source follow.
    public sealed class Wrap : IDisposable
    {
        readonly Handle handle;
        /// Whether at least half of both figures has a match. If not, check the directions of up and front, or use landmarks.
        public readonly bool Reached;
        /// Distances from the wrapped source's vertices to the target, relative to the target's height: mean, 95th percentile.
        public readonly double Mean, Upper;

        /// Finds the map. This takes seconds: call it on a thread of your own.
        ///   source, target  vertices and triangles; both have the same up and front, unless three or more landmarks align them
        ///   follow          points that will follow, such as the vertices of clothes; or null
        ///   landmarks       6 numbers each: a point of the source, and its place on the target; or null
        ///   otherPose       source and target have different poses; needs landmarks
        ///   finest          spans of the finest lattice along the target's height: 6, 12, 24, … 96
        ///   refineContacts  a finer lattice where parts touch, such as thighs; takes twice the time
        ///   threads         0: only the calling thread
        public Wrap(float[] source, int[] sourceFaces, float[] target, int[] targetFaces, float[] follow = null,
                    double[] landmarks = null, bool otherPose = false, int finest = 24, bool refineContacts = false, int threads = 0)
        {
            double[] marks = Landmarks(landmarks);
            using (var from = new Pinned(source, 3, "source"))
            using (var fromFaces = new Pinned(sourceFaces, "sourceFaces"))
            using (var to = new Pinned(target, 3, "target"))
            using (var toFaces = new Pinned(targetFaces, "targetFaces"))
            using (var followers = follow == null ? default(Pinned) : new Pinned(follow, 3, "follow"))
            using (var pinnedMarks = new Pinned(marks, "landmarks"))
            {
                Native.Drawing one = Native.DrawingOf(from, fromFaces, sourceFaces), other = Native.DrawingOf(to, toFaces, targetFaces);
                var options = new Native.WrapOptions { size = Native.SizeOf<Native.WrapOptions>(), landmarks = pinnedMarks.Address,
                                                       landmark_count = (UIntPtr)(marks.Length / 7), follow = followers.View,
                                                       other_pose = otherPose ? 1 : 0, refine_contacts = refineContacts ? 1 : 0,
                                                       finest = (uint)Native.Index(finest, "finest") };
                var running = new Native.Running { size = Native.SizeOf<Native.Running>(), threads = (uint)Native.Index(threads, "threads") };
                AlignedBytes report = Native.NewReport();
                try
                {
                    int code = Native.cageform_fit_wrap(IntPtr.Zero, ref one, ref other, ref options, ref running, out handle, report.Data);
                    Reached = code == 0;
                    if (code != Native.FitNotReached) Native.Check(code, report.Data);
                    Mean = Native.Number(report.Data, Native.OffsetOf("to_target_mean"));
                    Upper = Native.Number(report.Data, Native.OffsetOf("to_target_upper"));
                }
                finally
                {
                    report.Free();
                }
            }
        }

        /// Moves points of the source, 3 numbers each. `moved` may be the same array.
        public void Move(float[] points, float[] moved)
        {
            using (var from = new Pinned(points, 3, "points"))
            using (var to = new Pinned(moved, 3, points.Length / 3, "moved"))
                Native.Check(Native.cageform_wrap_move(handle, from.View, to.View, IntPtr.Zero, IntPtr.Zero));
        }

        /// Returns 7 numbers per landmark, as the library has: a point, its place, and a weight, 0 for 1.
        static double[] Landmarks(double[] given)
        {
            int count = given == null ? 0 : given.Length / 6;
            if (given != null && given.Length != 6 * count) throw new ArgumentException("6 numbers per landmark are needed", "landmarks");
            var marks = new double[7 * count];
            for (int n = 0; n < count; ++n) Array.Copy(given, 6 * n, marks, 7 * n, 6);
            return marks;
        }

        public void Dispose() { handle.Dispose(); }
    }

    /// An object of the library. It is freed before what it keeps alive: another object, or memory.
    public sealed class Handle : SafeHandle
    {
        Handle parent;
        AlignedBytes memory;

        Handle() : base(IntPtr.Zero, true) { }
        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        internal Handle Keep(Handle other)
        {
            bool added = false;
            other.DangerousAddRef(ref added);
            parent = other;
            return this;
        }
        internal Handle Keep(AlignedBytes other)
        {
            memory = other;
            return this;
        }
        protected override bool ReleaseHandle()
        {
            bool freed = Native.cageform_free(handle) == 0;
            if (parent != null) parent.DangerousRelease();
            memory.Free();
            return freed;
        }
    }

    /// Memory aligned to 64 bytes, as the library requires.
    struct AlignedBytes
    {
        IntPtr memory;
        public readonly IntPtr Data;
        public readonly UIntPtr Size;

        public AlignedBytes(int size)
        {
            memory = Marshal.AllocHGlobal(size + 64);
            Data = new IntPtr((memory.ToInt64() + 63) / 64 * 64);
            Size = (UIntPtr)size;
        }
        public AlignedBytes(byte[] bytes) : this((bytes ?? throw new ArgumentNullException("bytes")).Length)
        {
            Marshal.Copy(bytes, 0, Data, bytes.Length);
        }
        public void Free()
        {
            Marshal.FreeHGlobal(memory);
            memory = IntPtr.Zero;
        }
    }

    /// An array that is pinned during a call.
    struct Pinned : IDisposable
    {
        GCHandle held;
        public readonly Native.Points View;

        /// All points of an array.
        public Pinned(float[] numbers, int dimension, string name)
            : this(numbers, dimension, (numbers ?? throw new ArgumentNullException(name)).Length / dimension, name) { }
        /// An array of any numbers.
        public Pinned(Array numbers, string name)
        {
            if (numbers == null) throw new ArgumentNullException(name);
            held = GCHandle.Alloc(numbers, GCHandleType.Pinned);
            View = new Native.Points { data = held.AddrOfPinnedObject() };
        }
        public Pinned(float[] numbers, int dimension, int points, string name)
        {
            if (numbers == null) throw new ArgumentNullException(name);
            if (numbers.Length < (long)dimension * points)
                throw new ArgumentException(name + " has " + numbers.Length + (numbers.Length == 1 ? " number, " : " numbers, ") +
                                            (long)dimension * points + " are needed", name);
            held = GCHandle.Alloc(numbers, GCHandleType.Pinned);
            View = ViewOf(held.AddrOfPinnedObject(), dimension, points);
        }
        public IntPtr Address { get { return View.data; } }
        public static Native.Points ViewOf(IntPtr data, int dimension, int points)
        {
            return new Native.Points { data = data, count = (UIntPtr)points, bytes = (UIntPtr)(4UL * (ulong)dimension * (ulong)points),
                                       scalar = Native.Float, dimension = (uint)dimension };
        }
        public void Dispose()
        {
            if (held.IsAllocated) held.Free();
        }
    }

    static class Native
    {
        const string Library = "cageform"; // libcageform.so, libcageform.dylib, cageform.dll; linked statically: "__Internal"
        internal const uint Float = 0;
        internal const int FitNotReached = 970, ScalarDiffers = 1005, DimensionDiffers = 1006;

        // As in cageform.h; the test compares the offsets of members.
        [StructLayout(LayoutKind.Sequential)]
        internal struct Points // cageform_output is the same
        {
            internal IntPtr data;
            internal UIntPtr count, stride, bytes;
            internal uint scalar, dimension;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct FigureInfo
        {
            internal UIntPtr size, points, handles, vertices, clips, levels;
            internal uint scalar, dimension;
            internal int has_normals, has_tangents, has_labels;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 3)] internal double[] origin;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct ClipInfo
        {
            internal UIntPtr size, vertices;
            internal double begin, end;
            internal uint scalar, dimension;
            internal IntPtr name;
            internal UIntPtr name_length;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct SamplesInfo
        {
            internal UIntPtr size, handles;
            internal uint scalar, dimension;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct PinsOptions
        {
            internal UIntPtr size;
            internal double pin_weight;
            internal int hard;
            internal UIntPtr iterations;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Running
        {
            internal UIntPtr size;
            internal IntPtr context, parallel_for, progress;
            internal uint threads;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Drawing
        {
            internal UIntPtr size;
            internal Points points;
            internal IntPtr indices;
            internal UIntPtr index_count;
            internal IntPtr radii, areas;
            internal UIntPtr area_count;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct WrapOptions
        {
            internal UIntPtr size;
            internal IntPtr landmarks;
            internal UIntPtr landmark_count;
            internal Points follow;
            internal int keep_place, other_pose, refine_contacts;
            internal uint finest;
            internal double least_stiffness, floor, residual;
            internal UIntPtr samples, handles;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Fault
        {
            internal int status;
            internal uint a_is, b_is, reserved;
            internal UIntPtr a, b;
            internal IntPtr text;
        }
        [StructLayout(LayoutKind.Sequential)]
        internal struct Report
        {
            internal UIntPtr size;
            internal int status;
            internal uint faults, warnings, reserved;
            internal UIntPtr culprit;
            internal Fault fault;
            internal double seconds;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 256)] internal byte[] message;
            internal UIntPtr points, on_boundary, outside, faded, not_finite, unreached, not_restored;
            internal double partition_error, reproduction_error, least_weight, amplification;
            internal UIntPtr unknowns, memory;
            internal double grid_error, sufficient_accuracy;
            internal UIntPtr bytes, dense_bytes;
            internal double distance, mean_distance;
            internal UIntPtr vertices, components, tunnels;
            internal double margin, clearance, volume, tightest_volume, least_angle;
            internal UIntPtr samples, rotations;
            internal double miss, step, rigid_energy, least_stretch, largest_stretch;
            internal UIntPtr iterations, folded;
            internal int settled;
            internal double curve_error;
            internal UIntPtr bones, frame, beyond;
            internal double rms, max_distance, turn, mean_influences;
            internal double height, start, to_target_mean, to_target_upper, to_target_largest;
            internal double to_source_mean, to_source_upper, to_source_largest, unmatched_source, unmatched_target, noise;
            internal UIntPtr skipped_faces, left_out, far_followers;
            internal uint ended, of_target;
        }

        static readonly int culprit = OffsetOf("culprit"), message = OffsetOf("message");

        internal static AlignedBytes NewReport()
        {
            var room = new AlignedBytes((int)SizeOf<Report>());
            Marshal.WriteIntPtr(room.Data, (IntPtr)(int)SizeOf<Report>());
            return room;
        }
        internal static double Number(IntPtr report, int offset) { return BitConverter.Int64BitsToDouble(Marshal.ReadInt64(report, offset)); }
        internal static Drawing DrawingOf(Pinned points, Pinned faces, int[] corners)
        {
            return new Drawing { size = SizeOf<Drawing>(), points = points.View, indices = faces.Address,
                                 index_count = (UIntPtr)corners.Length };
        }
        internal static UIntPtr SizeOf<T>() { return (UIntPtr)Marshal.SizeOf(typeof(T)); }
        internal static int OffsetOf(string member) { return Marshal.OffsetOf(typeof(Report), member).ToInt32(); }
        internal static UIntPtr Index(int number, string name)
        {
            if (number < 0) throw new ArgumentOutOfRangeException(name);
            return (UIntPtr)number;
        }
        internal static void Check(int code)
        {
            if (code != 0) throw new CageformException(code);
        }
        /// Throws the error of a call with a report.
        internal static void Check(int code, IntPtr report)
        {
            if (code == 0) return;
            ulong named = (ulong)Marshal.ReadIntPtr(report, culprit).ToInt64();
            string text = Text(IntPtr.Add(report, message));
            throw new CageformException(code, named > uint.MaxValue ? null : named.ToString(), text.Length > 0 ? text : null);
        }
        internal static string Text(IntPtr text) { return Marshal.PtrToStringAnsi(text); }

        [DllImport(Library)] internal static extern IntPtr cageform_status_text(int status);
        [DllImport(Library)] internal static extern IntPtr cageform_status_name(int status);
        [DllImport(Library)] internal static extern int cageform_free(IntPtr item);
        [DllImport(Library)] internal static extern int cageform_open(IntPtr data, UIntPtr bytes, IntPtr options, out Handle figure,
                                                                      out UIntPtr culprit);
        [DllImport(Library)] internal static extern int cageform_open_level(Handle figure, UIntPtr level, IntPtr options,
                                                                            out Handle opened);
        [DllImport(Library)] internal static extern int cageform_figure_describe(Handle figure, ref FigureInfo info);
        [DllImport(Library)] internal static extern int cageform_figure_rest(Handle figure, Points handles);
        [DllImport(Library)] internal static extern int cageform_figure_label(Handle figure, UIntPtr handle, out IntPtr text,
                                                                              out UIntPtr length);
        [DllImport(Library)] internal static extern int cageform_figure_find_handle(Handle figure, byte[] text, UIntPtr length,
                                                                                    out UIntPtr handle);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, IntPtr normals,
                                                                       IntPtr tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, ref Points normals,
                                                                       IntPtr tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_clone(Handle figure, Points pose, Points points, ref Points normals,
                                                                       ref Points tangents, IntPtr running);
        [DllImport(Library)] internal static extern int cageform_pose_handles(Handle figure, Points vertices, Points handles);
        [DllImport(Library)] internal static extern int cageform_figure_find_clip(Handle figure, byte[] name, UIntPtr length,
                                                                                  out UIntPtr clip);
        [DllImport(Library)] internal static extern int cageform_play(Handle figure, UIntPtr clip, IntPtr options, out Handle player);
        [DllImport(Library)] internal static extern int cageform_player_describe(Handle player, ref ClipInfo info);
        [DllImport(Library)] internal static extern int cageform_player_sample(Handle player, double time, Points pose);
        [DllImport(Library)] internal static extern int cageform_samples_open(IntPtr data, UIntPtr bytes, int skip_checksum,
                                                                              out Handle samples);
        [DllImport(Library)] internal static extern int cageform_samples_describe(Handle samples, ref SamplesInfo info);
        [DllImport(Library)] internal static extern int cageform_pins_create(Handle samples, ref PinsOptions options, out Handle pins);
        [DllImport(Library)] internal static extern int cageform_pins_set(Handle pins, Handle figure, int[] points, UIntPtr count,
                                                                          double[] weights, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_pins_hold(Handle pins, int[] handles, UIntPtr count, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_pins_solve(Handle pins, Points targets, Points pose, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_fit_wrap(IntPtr coordinates, ref Drawing source, ref Drawing target,
                                                                          ref WrapOptions options, ref Running running,
                                                                          out Handle wrap, IntPtr report);
        [DllImport(Library)] internal static extern int cageform_wrap_move(Handle wrap, Points points, Points moved,
                                                                           IntPtr jacobians, IntPtr running);
    }
}
