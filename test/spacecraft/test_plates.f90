!> The trapezoidal satellite and its cross-sections.
module test_plates
    use vocabulary
    use gracecg_spacecraft_plates
    implicit none
    private
    public :: collect_plates

    !> CSR-TM-00-01 section 5.2, m
    real(dp), parameter :: LENGTH = 3.122_dp, HEIGHT = 0.720_dp
    real(dp), parameter :: WIDTH_BOTTOM = 1.942_dp, WIDTH_TOP = 0.693_dp

contains

    subroutine collect_plates(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('closes', test_closed), &
                    new_unittest('volume-and-centres', test_volume), &
                    new_unittest('edges-of-sides', test_edges), &
                    new_unittest('areas-along-axes', test_axes), &
                    new_unittest('sums-as-printed', test_printed), &
                    new_unittest('refuses-impossible', test_refuses)]
    end subroutine collect_plates

    function grace() result(surface)
        type(satellite_surface_t) :: surface

        type(error_t), allocatable :: failure

        call new_trapezoid(LENGTH, HEIGHT, WIDTH_BOTTOM, WIDTH_TOP, 0.0_dp, 0.0_dp, surface, failure)
    end function grace

    !> A pressure equal on all sides of (2-7) moves nothing and turns nothing.
    subroutine test_closed(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_surface_t) :: surface
        real(dp) :: force(3), torque(3)
        integer :: i

        surface = grace()
        force = 0
        torque = 0
        do i = 1, surface%count
            associate (plate => surface%plate(i))
                force = force + plate%area*plate%normal
                torque = torque + plate%area*cross(plate%centre, plate%normal)
            end associate
        end do
        call check(error, maxval(abs(force)) < 1e-14_dp)
        call check(error, maxval(abs(torque)) < 1e-14_dp)
    end subroutine test_closed

    !> Gauss: the integral of x.n over the surface is three times the volume. Then area and centroid
    !> of an end against the trapezoid cut into strips.
    subroutine test_volume(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STRIPS = 20000
        type(satellite_surface_t) :: surface
        real(dp) :: volume, z, width, area, moment
        integer :: i

        surface = grace()
        volume = 0
        do i = 1, surface%count
            associate (plate => surface%plate(i))
                volume = volume + plate%area*dot_product(plate%normal, plate%centre)/3
            end associate
        end do
        call check(error, volume, LENGTH*HEIGHT*(WIDTH_BOTTOM + WIDTH_TOP)/2, thr=1e-14_dp)
        area = 0
        moment = 0
        do i = 1, STRIPS
            z = HEIGHT*((i - 0.5_dp)/STRIPS - 0.5_dp)
            width = WIDTH_TOP + (WIDTH_BOTTOM - WIDTH_TOP)*(z/HEIGHT + 0.5_dp)
            area = area + width*HEIGHT/STRIPS
            moment = moment + z*width*HEIGHT/STRIPS
        end do
        call check(error, surface%area(1), area, thr=1e-12_dp)
        call check(error, surface%centre(1, 3), moment/area, thr=1e-9_dp)
    end subroutine test_volume

    !> The plane of each side of (2-7) holds the edges of bottom and top.
    subroutine test_edges(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_surface_t) :: surface
        integer :: i

        surface = grace()
        do i = 3, 4
            associate (side => surface%plate(i), y => sign(0.5_dp, surface%normal(i, 2)))
                call check(error, dot_product(side%normal, [0.3_dp, y*WIDTH_BOTTOM, HEIGHT/2] - &
                                              side%centre), 0.0_dp, thr=1e-15_dp)
                call check(error, dot_product(side%normal, [0.3_dp, y*WIDTH_TOP, -HEIGHT/2] - &
                                              side%centre), 0.0_dp, thr=1e-15_dp)
            end associate
        end do
    end subroutine test_edges

    !> Cross-sections (2-7), (2-9), (2-15) along the axes.
    subroutine test_axes(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: expected(3), direction(3)
        integer :: axis, side

        expected = [(WIDTH_BOTTOM + WIDTH_TOP)/2*HEIGHT, LENGTH*HEIGHT, WIDTH_BOTTOM*LENGTH]
        do axis = 1, 3
            do side = -1, 1, 2
                direction = 0
                direction(axis) = side
                call check(error, projected_area(grace(), direction), expected(axis), thr=1e-14_dp)
            end do
        end do
    end subroutine test_axes

    !> (2-7), (2-9), (2-15) as printed: S_i n_i.v H(n_i.v), H = -1 for n_i.v <= 0, else 0. With v from the Earth to the
    !> satellite that are the plates which face the Earth, below; with v along the flight or towards the Sun, those behind.
    subroutine test_printed(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: UP(3) = [0.02_dp, -0.1_dp, -0.99_dp]     !! From the Earth: z is down
        type(satellite_surface_t) :: surface
        real(dp) :: v(3), printed, facing
        integer :: i, side

        surface = grace()
        do side = -1, 1, 2
            v = side*UP/norm2(UP)
            printed = 0
            do i = 1, surface%count
                facing = dot_product(surface%normal(i, :), v)
                if (facing <= 0) printed = printed - surface%area(i)*facing
                if (side == 1 .and. facing <= 0) call check(error, surface%normal(i, 3) > -0.2_dp, 'faces the Earth')
            end do
            call check(error, printed, projected_area(surface, -v), thr=1e-14_dp)
            call check(error, printed, projected_area(surface, v), thr=1e-14_dp)
        end do
    end subroutine test_printed

    subroutine test_refuses(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_surface_t) :: good, surface
        type(plate_t) :: plates(6)
        type(error_t), allocatable :: failure
        integer :: i

        good = grace()
        call new_trapezoid(-LENGTH, HEIGHT, WIDTH_BOTTOM, WIDTH_TOP, 0.0_dp, 0.0_dp, surface, failure)
        call check_fails(error, failure, 'positive')
        call new_trapezoid(LENGTH, HEIGHT, WIDTH_BOTTOM, NAN, 0.0_dp, 0.0_dp, surface, failure)
        call check_fails(error, failure, 'positive')
        call new_trapezoid(LENGTH, HEIGHT, WIDTH_BOTTOM, WIDTH_TOP, 0.7_dp, 0.4_dp, surface, failure)
        call check_fails(error, failure, 'specular')
        plates = [(good%plate(i), i=1, 6)]
        plates(2)%area = 1.01_dp*plates(2)%area
        call new_surface(plates, surface, failure)
        call check_fails(error, failure, 'do not close')
        plates = [(good%plate(i), i=1, 6)]
        plates(4)%normal = 1.001_dp*plates(4)%normal
        call new_surface(plates, surface, failure)
        call check_fails(error, failure, 'length 1')
        plates = [(good%plate(i), i=1, 6)]
        plates(5)%centre(1) = NAN
        call new_surface(plates, surface, failure)
        call check_fails(error, failure, 'centre')
        call new_surface(spread(plates(1), 1, MAX_PLATES + 1), surface, failure)
        call check_fails(error, failure, '33 plates')
    end subroutine test_refuses
end module test_plates
