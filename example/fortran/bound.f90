!> How well can a manoeuvre show the offset at all? The least standard deviation that any unbiased
!> estimate can have, and the direction in which the manoeuvre sees least.
!>
!>     gfortran bound.f90 $(pkg-config --cflags --libs gracecg)
!>
!> The numbers are those of `gracecg bound front-2`.
program bound
    use gracecg, only: MILLIMETRE, error_t, case_t, find_case, estimation_options_t, case_bound_t, &
        bound_of_case, BOUND_SOURCES
    implicit none
    type(case_t) :: case
    type(case_bound_t) :: limit
    type(error_t), allocatable :: error
    integer :: i

    call find_case('front-2', case, error)
    if (.not. allocated(error)) call bound_of_case(case, estimation_options_t(), limit, error)
    if (allocated(error)) error stop error%message

    print '(a)', 'front-2, body axes, mm'
    print '(a, 3es18.9)', 'sigma   ', limit%sigma/MILLIMETRE
    print '(a, es18.9)', 'worst   ', limit%principal_sigma(3)/MILLIMETRE
    print '(a, 3es18.9)', 'along   ', limit%direction(:, 3)
    print '(a, 3es18.9)', 'in all  ', limit%consider_sigma/MILLIMETRE
    do i = 1, size(BOUND_SOURCES)
        print '(2a, 3es18.9)', '  by ', BOUND_SOURCES(i), limit%by_source(:, i)/MILLIMETRE
    end do

    ! a manoeuvre that shows nothing has no bound: that is said, and nothing stops
    case%satellite%rods%count = 0
    call bound_of_case(case, estimation_options_t(), limit, error)
    if (allocated(error)) print '(2a)', 'without rods: ', error%message
end program bound
