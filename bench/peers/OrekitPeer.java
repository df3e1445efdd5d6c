// Orekit's gravity field and orbit with the coefficients of data/egm96_deg70.gfc: for bench/peers.py.
//     OrekitPeer FOLDER gravity DEGREE | orbit
import java.io.File;
import java.util.Locale;
import org.hipparchus.geometry.euclidean.threed.Vector3D;
import org.hipparchus.ode.nonstiff.DormandPrince853Integrator;
import org.orekit.data.DataContext;
import org.orekit.data.DirectoryCrawler;
import org.orekit.forces.gravity.HolmesFeatherstoneAttractionModel;
import org.orekit.forces.gravity.NewtonianAttraction;
import org.orekit.forces.gravity.potential.GravityFieldFactory;
import org.orekit.forces.gravity.potential.ICGEMFormatReader;
import org.orekit.forces.gravity.potential.NormalizedSphericalHarmonicsProvider;
import org.orekit.frames.Frame;
import org.orekit.frames.FramesFactory;
import org.orekit.orbits.CartesianOrbit;
import org.orekit.orbits.OrbitType;
import org.orekit.propagation.SpacecraftState;
import org.orekit.propagation.numerical.NumericalPropagator;
import org.orekit.time.AbsoluteDate;
import org.orekit.utils.PVCoordinates;

public class OrekitPeer {
    static final double R = 6.838e6;
    static double total = 0;

    static Vector3D place(int i) {
        final double a = 2 * Math.PI * ((i * 0.618034) % 1.0);
        final double b = 2 * Math.PI * ((i * 0.381966 * 0.5) % 0.5 - 0.25) * 0.98;
        return new Vector3D(R * (Math.cos(b) * Math.cos(a)), R * (Math.cos(b) * Math.sin(a)), R * Math.sin(b));
    }

    static Vector3D acceleration(HolmesFeatherstoneAttractionModel model, Vector3D r, double mu) {
        final double[] g = model.gradient(AbsoluteDate.J2000_EPOCH, r, mu);     // without the central part
        final double d = r.getNorm();
        final double c = -mu / (d * d * d);
        return new Vector3D(c * r.getX() + g[0], c * r.getY() + g[1], c * r.getZ() + g[2]);
    }

    public static void main(String[] args) {
        Locale.setDefault(Locale.ROOT);
        DataContext.getDefault().getDataProvidersManager().addProvider(new DirectoryCrawler(new File(args[0])));
        GravityFieldFactory.addPotentialCoefficientsReader(new ICGEMFormatReader("peer\\.gfc", true));
        final int degree = args.length > 2 ? Integer.parseInt(args[2]) : 20;
        final NormalizedSphericalHarmonicsProvider provider =
            GravityFieldFactory.getConstantNormalizedProvider(degree, degree, AbsoluteDate.J2000_EPOCH);
        final Frame frame = FramesFactory.getGCRF();        // an Earth that does not turn
        final HolmesFeatherstoneAttractionModel model = new HolmesFeatherstoneAttractionModel(frame, provider);
        if (args[1].equals("gravity")) {
            gravity(model, provider.getMu(), degree);
        } else {
            orbit(model, provider.getMu(), frame);
        }
        if (total == 1e300) System.out.println(total);
    }

    static void gravity(HolmesFeatherstoneAttractionModel model, double mu, int degree) {
        final Vector3D[] places = new Vector3D[1000];
        for (int i = 1; i <= 1000; i++) places[i - 1] = place(i);
        final int calls = 400000 / degree;
        double best = 1e9;
        for (int repeat = 0; repeat < 25; repeat++) {       // the first ones warm the compiler
            final long start = System.nanoTime();
            for (int k = 1; k <= calls; k++) total += acceleration(model, places[k % 1000], mu).getX();
            best = Math.min(best, (System.nanoTime() - start) * 1e-9 / calls);
        }
        System.out.printf("seconds %.6e%n", best);
        for (int i = 0; i < 5; i++) {
            final Vector3D a = acceleration(model, places[i], mu);
            System.out.printf("value %.16e %.16e %.16e%n", a.getX(), a.getY(), a.getZ());
        }
    }

    static void orbit(HolmesFeatherstoneAttractionModel model, double mu, Frame frame) {
        final double[] tolerances = {1e-7, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6};       // m; the first: reference
        for (double tolerance : tolerances) {
            double best = 1e9;
            Vector3D end = Vector3D.ZERO;
            for (int repeat = 0; repeat < 12; repeat++) {
                final double v = 1e-3 * tolerance;          // m/s; the last is of the mass, which stays
                final double[] absolute = {tolerance, tolerance, tolerance, v, v, v, 1};
                final NumericalPropagator propagator = new NumericalPropagator(
                    new DormandPrince853Integrator(1e-3, 600, absolute, new double[7]));
                propagator.setOrbitType(OrbitType.CARTESIAN);
                propagator.addForceModel(new NewtonianAttraction(mu));
                propagator.addForceModel(model);
                propagator.setInitialState(new SpacecraftState(new CartesianOrbit(
                    new PVCoordinates(new Vector3D(R, 0, 0), new Vector3D(0, 120, 7634)), frame, AbsoluteDate.J2000_EPOCH, mu)));
                final long start = System.nanoTime();
                end = propagator.propagate(AbsoluteDate.J2000_EPOCH.shiftedBy(86400.0)).getPosition();
                best = Math.min(best, (System.nanoTime() - start) * 1e-9);
            }
            System.out.printf("run %.6e %.6e %.16e %.16e %.16e%n", tolerance, best, end.getX(), end.getY(), end.getZ());
        }
    }
}
