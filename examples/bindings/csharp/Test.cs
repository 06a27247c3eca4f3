// Tests of Cageform.cs: Test.exe FOLDER. figure.py writes FOLDER.
using System;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;
using System.Text;
using Cageform;

static class Test
{
    static int passed, failed;
    static string folder;

    static int Main(string[] arguments)
    {
        if (arguments.Length != 1)
        {
            Console.Error.WriteLine("usage: Test.exe FOLDER");
            return 2;
        }
        folder = arguments[0];
        Run("structs have the layout of C", Layout);
        Run("clones are bitwise equal to those of Python", Clones);
        Run("clones at addresses", Addresses);
        Run("labels", Labels);
        Run("a clip, a level", Clip);
        Run("pins", PullPins);
        Run("a wrap is bitwise equal to that of Python", Wraps);
        Run("errors", Errors);
        Run("a thousand frames allocate nothing", Frames);
        Run("objects are freed in any order", Order);
        Console.WriteLine("{0} passed, {1} failed", passed, failed);
        return failed == 0 ? 0 : 1;
    }

    static void Run(string name, Action test)
    {
        try
        {
            test();
            ++passed;
        }
        catch (Exception error)
        {
            ++failed;
            Console.WriteLine("FAILED: {0}: {1}", name, error);
        }
    }

    static void Require(bool holds, [CallerLineNumber] int line = 0)
    {
        if (!holds) throw new Exception("line " + line);
    }
    static byte[] Read(string name) { return File.ReadAllBytes(Path.Combine(folder, name)); }
    static float[] Floats(string name)
    {
        byte[] bytes = Read(name);
        var numbers = new float[bytes.Length / 4];
        Buffer.BlockCopy(bytes, 0, numbers, 0, bytes.Length);
        return numbers;
    }
    static CageformException Refused(Action call)
    {
        try
        {
            call();
        }
        catch (CageformException error)
        {
            return error;
        }
        throw new Exception("no exception");
    }
    static E Throws<E>(Action call) where E : Exception
    {
        try
        {
            call();
        }
        catch (E error)
        {
            return error;
        }
        throw new Exception("no " + typeof(E).Name);
    }

    static void Layout()
    {
        var structs = typeof(Figure).Assembly.GetType("Cageform.Native").GetNestedTypes(BindingFlags.NonPublic);
        int compared = 0;
        foreach (string line in File.ReadAllLines(Path.Combine(folder, "layout.txt")))
        {
            string[] words = line.Split(' ', '.');
            string name = string.Concat(words[0].Substring(9).Split('_').Select(word => char.ToUpper(word[0]) + word.Substring(1)));
            Type type = structs.FirstOrDefault(one => one.Name == name);
            if (type == null) continue;
            int own = words.Length == 2 ? Marshal.SizeOf(type) : Marshal.OffsetOf(type, words[1]).ToInt32();
            if (own != int.Parse(words[words.Length - 1])) throw new Exception(line + ", not " + own);
            compared += words.Length == 2 ? 1 : 0;
        }
        Require(compared == structs.Length);
    }

    static void Clones()
    {
        using (var figure = new Figure(Read("figure")))
        {
            Require(figure.Points == 500 && figure.Handles == 8 && figure.Vertices == 8 && figure.Clips == 2 && figure.Levels == 1);
            Require(figure.Origin[0] == 5e5 && figure.Origin[1] == 4.6e6 && figure.Origin[2] == 0.1);
            Require(figure.HasNormals && figure.HasTangents);
            float[] pose = Floats("pose"), points = new float[1500], normals = new float[1500], tangents = new float[2000];
            figure.Clone(pose, points, normals, tangents);
            Require(points.SequenceEqual(Floats("moved")));
            Require(normals.SequenceEqual(Floats("turned")));
            Require(tangents.SequenceEqual(Floats("along")));
            float[] alone = new float[1500], some = new float[1500];
            figure.Clone(pose, alone);
            figure.Clone(pose, alone, some);
            Require(alone.SequenceEqual(points) && some.SequenceEqual(normals));
            Require(Refused(() => figure.Clone(pose, alone, null, tangents)).Name == "argument_null");
            figure.Rest(pose);
            Require(pose[0] == -1 && pose[23] == 1);
            var handles = new float[24];
            figure.PoseHandles(pose, handles);
            Require(handles.SequenceEqual(pose));
        }
    }

    static void Addresses()
    {
        using (var figure = new Figure(Read("figure")))
        {
            float[] pose = Floats("pose"), points = new float[1500];
            IntPtr from = Marshal.AllocHGlobal(4 * pose.Length), to = Marshal.AllocHGlobal(4 * points.Length);
            Marshal.Copy(pose, 0, from, pose.Length);
            figure.Clone(from, to, IntPtr.Zero, IntPtr.Zero);
            Marshal.Copy(to, points, 0, points.Length);
            Marshal.FreeHGlobal(from);
            Marshal.FreeHGlobal(to);
            Require(points.SequenceEqual(Floats("moved")));
            Require(Refused(() => figure.Clone(IntPtr.Zero, IntPtr.Zero, IntPtr.Zero, IntPtr.Zero)).Name == "argument_null");
        }
    }

    static void Labels()
    {
        using (var figure = new Figure(Read("figure")))
        {
            Require(figure.Label(0) == "left foot" && figure.Label(1) == "" && figure.Label(2) == "hand \u270b");
            Require(figure.FindHandle("hand \u270b") == 2 && figure.FindHandle("head") == -1);
            Throws<ArgumentOutOfRangeException>(() => figure.Label(-1));
            Throws<CageformException>(() => figure.Label(8));
        }
    }

    static void Clip()
    {
        using (var figure = new Figure(Read("figure")))
        using (var player = figure.Play("grow"))
        using (var level = figure.Level(1))
        {
            Require(player.Vertices == 8 && player.Begin == 0 && player.End == 3);
            var vertices = new float[24];
            player.Sample(1.5, vertices);
            Require(vertices.SequenceEqual(Floats("sampled")));
            Require(Refused(() => player.Sample(double.NaN, vertices)).Code != 0);
            using (var late = figure.Play("late")) // its times are equal in float
            {
                Require(late.Begin == 70000.5);
                for (int k = 0; k < 30; ++k)
                {
                    late.Sample(70000.5 + k / 500.0, vertices);
                    Require(Math.Abs(vertices[0] - (k - 1)) < 1e-3);
                }
            }
            Throws<ArgumentException>(() => figure.Play("walk"));
            var points = new float[150];
            Require(level.Points == 50);
            level.Clone(Floats("pose"), points);
            Require(points.SequenceEqual(Floats("level")));
        }
    }

    static void PullPins()
    {
        using (var figure = new Figure(Read("figure")))
        using (var pins = new Pins(Read("samples")))
        {
            var pose = new float[24];
            figure.Rest(pose);
            pins.Set(figure, new[] { 0, 7, 9 });
            float[] targets = Floats("targets");
            bool settled = pins.Solve(targets, pose);
            Require(pose.SequenceEqual(Floats("pulled")));
            for (int frame = 0; frame < 200 && !settled; ++frame) settled = pins.Solve(targets, pose);
            Require(settled && pins.Miss < 0.01);
            var error = Refused(() => pins.Set(figure, new[] { 0, 7, 500 }));
            Require(error.Name == "index_out_of_range" && error.Message.EndsWith("(pin 2)"));
            Require(error.Culprit == "2");
            Throws<ArgumentException>(() => pins.Set(figure, new[] { 0, 7 }, new double[1]));
            foreach (var words in new[] { "0 numbers", "1 number", "8 numbers" })
            {
                var few = Throws<ArgumentException>(() => pins.Solve(new float[words[0] - '0'], pose));
                Require(few.Message.Contains(" has " + words + ", 9 are needed"));
            }
            pins.Hold(new[] { 0 });
            Require(Refused(() => pins.Hold(new[] { 3, 8 })).Culprit == "8");
        }
        Require(Refused(() => new Pins(Read("figure"))).Code != 0);
    }

    static void Wraps()
    {
        float[] source = Floats("source"), target = Floats("target"), coat = Floats("coat"), moved = new float[coat.Length];
        var faces = new int[Read("faces").Length / 4];
        Buffer.BlockCopy(Read("faces"), 0, faces, 0, 4 * faces.Length);
        var landmarks = source.Take(3).Concat(target.Take(3)).Select(x => (double)x).ToArray();
        using (var wrap = new Wrap(source, faces, target, faces, coat, landmarks, finest: 12, threads: 2))
        {
            wrap.Move(coat, moved);
            Require(moved.SequenceEqual(Floats("coat_moved")));
            Require(wrap.Reached && wrap.Mean > 0 && wrap.Mean < wrap.Upper && wrap.Upper < 0.01);
            Throws<ArgumentException>(() => wrap.Move(coat, new float[3]));
            wrap.Dispose();
            Throws<ObjectDisposedException>(() => wrap.Move(coat, moved));
        }
        var thick = source.Select((x, n) => n % 3 == 2 ? x : 1.5f * x).ToArray();
        using (var wrap = new Wrap(thick, faces.Reverse().ToArray(), thick, faces, finest: 6)) // inside out
            Require(!wrap.Reached);
        Throws<ArgumentNullException>(() => new Wrap(null, faces, target, faces));
        Throws<ArgumentException>(() => new Wrap(source, faces, target, faces, null, new double[7]));
        target[16] = float.NaN;
        var error = Refused(() => new Wrap(source, faces, target, faces));
        Require(error.Name == "figure_not_finite" && error.Culprit == "5" && error.Message.EndsWith("(target vertex 5)"));
    }

    static void Errors()
    {
        byte[] bytes = Read("figure");
        Require(Refused(() => new Figure(new byte[0])).Name == "not_a_figure");
        Require(Refused(() => new Figure(Read("plane"))).Code > 1000);
        Throws<ArgumentNullException>(() => new Figure(null));
        var random = new Random(1);
        for (int n = 0; n < 300; ++n)
        {
            var spoilt = (byte[])bytes.Clone();
            spoilt[random.Next(bytes.Length)] ^= (byte)(1 << random.Next(8));
            Require(Refused(() => new Figure(spoilt)).Message.Length > 5);
            Refused(() => new Figure(bytes.Take(random.Next(bytes.Length)).ToArray()));
        }
        using (var figure = new Figure(bytes))
        {
            float[] pose = Floats("pose"), points = new float[1500];
            Throws<ArgumentException>(() => figure.Clone(new float[23], points));
            Throws<ArgumentException>(() => figure.Clone(pose, new float[1499]));
            Throws<ArgumentNullException>(() => figure.Clone(null, points));
            pose[4] = float.NaN;
            var error = Refused(() => figure.Clone(pose, points));
            Require(error.Name == "pose_not_finite" && error.Culprit == null && error.Message.Length > 10);
            figure.Dispose();
            Throws<ObjectDisposedException>(() => figure.Clone(pose, points));
        }
    }

    static void Frames()
    {
        using (var figure = new Figure(Read("figure")))
        using (var player = figure.Play("grow"))
        using (var pins = new Pins(Read("samples")))
        {
            float[] vertices = new float[24], pose = new float[24], points = new float[1500], normals = new float[1500];
            float[] tangents = new float[2000], targets = Floats("targets");
            pins.Set(figure, new[] { 0, 7, 9 });
            Action<int> frames = count =>
            {
                for (int frame = 0; frame < count; ++frame)
                {
                    player.Sample(frame * 0.01, vertices);
                    figure.PoseHandles(vertices, pose);
                    pins.Solve(targets, pose);
                    figure.Clone(pose, points, normals, tangents);
                }
            };
            frames(10);
            long before = GC.GetTotalMemory(true), collections = GC.CollectionCount(0);
            frames(1000);
            Require(GC.GetTotalMemory(false) - before < 4096 && GC.CollectionCount(0) == collections);
        }
    }

    static void Order()
    {
        float[] vertices = new float[24], points = new float[1500], pose = Floats("pose");
        for (int n = 0; n < 20; ++n)
        {
            var figure = new Figure(Read("figure"));
            Player player = figure.Play("grow");
            Figure level = figure.Level(0);
            figure.Dispose();
            player.Sample(1.5, vertices);
            level.Clone(pose, points);
            Require(vertices.SequenceEqual(Floats("sampled")) && points.SequenceEqual(Floats("moved")));
            figure.Dispose();
            player.Dispose();
            player.Dispose();
            level.Dispose();
        }
        for (int n = 0; n < 50; ++n) // freed by the garbage collector in any order
        {
            new Figure(Read("figure")).Play("grow").Sample(1, vertices);
            new Pins(Read("samples"));
        }
        GC.Collect();
        GC.WaitForPendingFinalizers();
        GC.Collect();
    }
}
